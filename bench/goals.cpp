#include "bench/ratio_table.h"

namespace credence {

std::span<const RatioGoal> ratio_goals() {
  static const std::vector<RatioGoal> goals = {
      {.work = "monobot, N = 1, one step of one run, NEES and NIS, noise included",
       .limit = "drawing its two normals",
       .measured = {"lanes/{set}/1", "items"},
       .reference = {"noise_alone/{set}/1", "items"},
       .goal = 1.25},
      {.work = "the same",
       .limit = "a plain Eigen loop with the standard library's normals",
       .measured = {"lanes/{set}/1", "items"},
       .reference = {"plain_loop/1", "items"},
       .goal = 20.0,
       .at_least = true},
      {.work = "the same with AVX2",
       .limit = "the same plain loop",
       .measured = {"lanes/avx2/1", "items"},
       .reference = {"plain_loop/1", "items"},
       .goal = 10.0,
       .at_least = true},
      {.work = "full filter, explicit P, N = 100, m = 1, one step",
       .limit = "streaming one triangle of P in place",
       .measured = {"fast_step/100/1/1", "items"},
       .reference = {"stream_triangle/{set}/100"},
       .goal = 1.2},
      {.work = "the same, N = 500",
       .limit = "streaming one triangle of P in place",
       .measured = {"fast_step/500/1/1", "items"},
       .reference = {"stream_triangle/{set}/500"},
       .goal = 1.2},
      {.work = "the same, N = 1000",
       .limit = "streaming one triangle of P in place",
       .measured = {"fast_step/1000/1/1", "items"},
       .reference = {"stream_triangle/{set}/1000"},
       .goal = 1.2},
      {.work = "full filter, a flush every 12 steps, N = 1000, m = 1, a multiply-add",
       .limit = "a multiply-add in registers",
       .measured = {"fast_step/1000/1/12", "multiply_adds"},
       .reference = {"multiply_adds/{set}", "items"},
       .goal = 1.6},
      {.work = "full filter, N = 1000, m = 10, a multiply-add",
       .limit = "a multiply-add in registers",
       .measured = {"fast_step/1000/10/8", "multiply_adds"},
       .reference = {"multiply_adds/{set}", "items"},
       .goal = 1.7},
  };
  return goals;
}

}  // namespace credence

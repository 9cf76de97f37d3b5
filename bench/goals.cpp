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
  };
  return goals;
}

}  // namespace credence

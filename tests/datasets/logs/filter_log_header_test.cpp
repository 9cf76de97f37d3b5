#include "datasets/logs/filter_log_header.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace credence::internal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

void expect_header_error(const std::string& line, const std::string& problem) {
  EXPECT_THAT([&] { parse_filter_log_header(line); },
              ::testing::ThrowsMessage<std::invalid_argument>(HasSubstr(problem)));
}

TEST(FilterLogHeaderLine, columns_are_found_in_any_order) {
  const FilterLogHeader h = parse_filter_log_header(
      "P.2.2,truth.b.y,S.odo.1.1,estimate.x:angle,step,P.1.1,estimate.b.y,innovation.odo.1,time,truth.x,P.1."
      "2,run");
  EXPECT_EQ(h.columns, 12);
  EXPECT_EQ(h.run, 11);
  EXPECT_EQ(h.step, 4);
  EXPECT_EQ(h.time, 8);
  EXPECT_THAT(h.layout.states, ElementsAre("x", "b.y"));
  EXPECT_THAT(h.layout.angles, ElementsAre(true, false));
  EXPECT_THAT(h.layout.units, IsEmpty()) << "no column says them";
  EXPECT_THAT(h.estimate, ElementsAre(3, 6));
  EXPECT_THAT(h.truth, ElementsAre(9, 1)) << "in the order of the estimates";
  EXPECT_THAT(h.P.upper, ElementsAre(5, 10, 0));
  EXPECT_THAT(h.P.lower, ElementsAre(-1, -1, -1));
  EXPECT_EQ(h.layout.sensors, (std::vector<Sensor>{{.name = "odo", .dim = 1, .piece = 1}}));
  EXPECT_THAT(h.innovations.at(0).nu, ElementsAre(7));
  EXPECT_THAT(h.innovations[0].S.upper, ElementsAre(2));
  EXPECT_TRUE(h.layout.has_truth);
}

TEST(FilterLogHeaderLine, what_is_not_there_has_no_column) {
  const FilterLogHeader h = parse_filter_log_header("innovation.1,S.1.1,estimate.x");
  EXPECT_EQ(h.run, -1);
  EXPECT_EQ(h.step, -1);
  EXPECT_EQ(h.time, -1);
  EXPECT_THAT(h.truth, IsEmpty());
  EXPECT_FALSE(h.layout.has_truth);
  EXPECT_THAT(h.P.upper, IsEmpty());
  EXPECT_EQ(h.layout.sensors.at(0).name, "");
}

TEST(FilterLogHeaderLine, a_matrix_may_be_either_triangle_or_both) {
  const std::string states = "estimate.x,estimate.y,truth.x,truth.y,";
  const auto P = [&](const std::string& columns) { return parse_filter_log_header(states + columns).P; };
  EXPECT_THAT(P("P.1.1,P.1.2,P.2.2").upper, ElementsAre(4, 5, 6));
  EXPECT_THAT(P("P.1.1,P.2.1,P.2.2").upper, ElementsAre(4, 5, 6));
  EXPECT_THAT(P("P.1.1,P.2.1,P.2.2").lower, ElementsAre(-1, -1, -1));
  EXPECT_THAT(P("P.1.1,P.1.2,P.2.1,P.2.2").upper, ElementsAre(4, 5, 7));
  EXPECT_THAT(P("P.1.1,P.1.2,P.2.1,P.2.2").lower, ElementsAre(-1, 6, -1));
}

TEST(FilterLogHeaderLine, numbers_count_from_0_where_one_is_0) {
  const FilterLogHeader h = parse_filter_log_header(
      "error.x,error.y,P.0.0,P.0.1,P.1.1,innovation.0:angle,innovation.1:next:angle,S.0.0,S.0.1,S.1.1,R.0.0");
  EXPECT_THAT(h.P.upper, ElementsAre(2, 3, 4));
  EXPECT_THAT(h.innovations.at(0).nu, ElementsAre(5, 6));
  EXPECT_THAT(h.innovations[0].S.upper, ElementsAre(7, 8, 9));
  EXPECT_THAT(h.innovations[0].R.upper, ElementsAre(10));
  EXPECT_EQ(h.innovations[0].noise_dim, 1);
  EXPECT_THAT(h.layout.sensors.at(0).angles, ElementsAre(true));
  EXPECT_EQ(h.layout.sensors[0].piece, 1);
  expect_header_error("error.x,error.y,P.0.0,P.1.1", "column P.0.1 is missing");
  expect_header_error("error.x,P.0.0,P.0.1,P.1.1", "column P.0.1 lies outside its 1×1 matrix");
  expect_header_error("innovation.0,innovation.2,S.1.1", "column innovation.1 is missing");
  expect_header_error("nis.0", "unknown column 'nis.0'");
}

TEST(FilterLogHeaderLine, entries_of_P_may_name_their_states) {
  const FilterLogHeader h = parse_filter_log_header("P.b.y.x,error.x:angle,P.x.x,error.b.y,P.b.y.b.y");
  EXPECT_THAT(h.P.upper, ElementsAre(2, 0, 4));
  EXPECT_THAT(parse_filter_log_header("error.x,error.y,P.x.x,P.1.2,P.y.y").P.upper, ElementsAre(2, 3, 4));
  EXPECT_THAT(parse_filter_log_header("error.x,error.y,P.0.0,P.x.y,P.1.1").P.upper, ElementsAre(2, 3, 4));
  expect_header_error("error.x,P.x.z", "unknown column 'P.x.z'");
  expect_header_error("error.x,P.x.x,P.1.1", "columns P.1.1 and P.x.x: what they stand for is there twice");
}

TEST(FilterLogHeaderLine, names_may_stand_in_quotes_between_blanks) {
  const FilterLogHeader h = parse_filter_log_header("\"step\", \"estimate.x\"\t, truth.x ,\tP.1.1");
  EXPECT_EQ(h.step, 0);
  EXPECT_THAT(h.estimate, ElementsAre(1));
  EXPECT_THAT(h.truth, ElementsAre(2));
  EXPECT_THAT(h.P.upper, ElementsAre(3));
}

TEST(FilterLogHeaderLine, sensors_stand_in_the_order_of_their_first_column) {
  const FilterLogHeader h = parse_filter_log_header(
      "S.b.1.1,nis.a.3,innovation.b.1:angle,innovation.c.d.2,innovation.c.d.1,S.c.d.1.1,S.c.d.2.1,S.c.d.2.2");
  EXPECT_EQ(h.layout.sensors, (std::vector<Sensor>{{.name = "b", .dim = 1, .piece = 1, .angles = {true}},
                                                   {.name = "a", .dim = 3, .piece = 3, .nis_alone = true},
                                                   {.name = "c.d", .dim = 2, .piece = 2}}));
  EXPECT_THAT(h.innovations.at(1).nu, ElementsAre(1));
  EXPECT_THAT(h.innovations.at(2).nu, ElementsAre(4, 3));
}

TEST(FilterLogHeaderLine, angles_of_one_observation_repeat_in_every_further_one) {
  std::string line = "innovation.1,innovation.2:angle,innovation.3:next,innovation.4:angle";
  for (int i = 1; i <= 4; ++i) {
    for (int j = i; j <= 4; ++j) line += ",S." + std::to_string(i) + "." + std::to_string(j);
  }
  const Sensor sensor = parse_filter_log_header(line).layout.sensors.at(0);
  EXPECT_EQ(sensor.piece, 2);
  EXPECT_THAT(sensor.angles, ElementsAre(false, true));
  line.replace(line.find("innovation.4:angle"), 18, "innovation.4");
  expect_header_error(line, "column innovation.4: an angle in one observation and not in another");
}

TEST(FilterLogHeaderLine, columns_that_cannot_be_meant_are_named) {
  expect_header_error("", "a column has no name");
  expect_header_error("step,,time", "a column has no name");
  expect_header_error("step,", "a column has no name");
  expect_header_error("k,step,xt,yt", "unknown columns 'k', 'xt', 'yt': accepted are");
  expect_header_error("a,b,c,d,e,f,g,h,i,j,k,l,m,n", "'l' and 2 more: accepted are");
  for (const char* name : {"Step",
                           "estimate.",
                           "estimate.:angle",
                           "estimate",
                           "truth.",
                           "P.1",
                           "P.a.b",
                           "P.1.2001",
                           "P.1.1.1",
                           "P.x.1.1",
                           "innovation",
                           "innovation.",
                           "innovation.x",
                           "innovation..1",
                           "innovationx.1",
                           "S.1",
                           "S..1.1",
                           "nis",
                           "nis.x",
                           "nis.0",
                           "nis.-1",
                           "nis.1.5x",
                           "P.1.99999999999999999999",
                           "innovation.1:next:other"}) {
    expect_header_error(std::string("innovation.1,S.1.1,") + name, std::string("unknown column '") + name);
  }
  expect_header_error("estimate.x,estimate.x:angle,truth.x,P.1.1", "column estimate.x is there twice");
  for (const std::string name : {"step", "run", "time", "inflated", "truth.x", "P.1.1", "P.x.x",
                                 "innovation.1", "S.gps.1.1", "R.1.1", "nis.2"}) {
    expect_header_error("error.x," + name + "," + name, "column " + name + " is there twice");
  }
  for (const auto& [first, second] :
       {std::pair("S.1.1", "S.01.1"), std::pair("nis.2", "nis.3"), std::pair("truth.x", "truth.x:angle")}) {
    expect_header_error(fmt::format("{},{}", first, second),
                        fmt::format("columns {} and {}: what they stand for is there twice", first, second));
  }
}

TEST(FilterLogHeaderLine, columns_that_are_missing_are_named) {
  expect_header_error("estimate.x,estimate.y,truth.y,P.1.1,P.1.2,P.2.2", "column truth.x is missing");
  expect_header_error("truth.y,estimate.x,truth.x,P.1.1", "column estimate.y is missing");
  expect_header_error("truth.y", "column estimate.y is missing");
  expect_header_error("estimate.x,estimate.y,truth.x,truth.y,P.1.1,P.2.2", "column P.1.2 is missing");
  expect_header_error("estimate.x,P.2.2,innovation.1,S.1.1", "column P.2.2 lies outside its 1×1 matrix");
  expect_header_error("estimate.x,P.1.1,P.2.1,innovation.1,S.1.1",
                      "column P.2.1 lies outside its 1×1 matrix");
  expect_header_error("S.gps.1.1", "column innovation.gps.1 is missing");
  expect_header_error("innovation.2,S.1.1,S.1.2,S.2.2", "column innovation.1 is missing");
  expect_header_error("innovation.gps.1,S.gps.2.2", "column S.gps.2.2 lies outside its 1×1 matrix");
  expect_header_error("nis.gps.2,innovation.gps.1", "column nis.gps.2 beside innovation.gps, S.gps or R.gps");
  expect_header_error("nis.2,S.1.1", "name one of them");
  for (const char* line : {"step", "run,step,time", "estimate.x", "estimate.x,P.1.1"}) {
    expect_header_error(line, "nothing to judge");
  }
}

TEST(FilterLogHeaderLine, another_separator_and_json_are_named) {
  expect_header_error("estimate.x;truth.x;P.1.1", "separated by ';' where ',' is expected");
  expect_header_error("estimate.x\ttruth.x\tP.1.1", "separated by tabs where ',' is expected");
  expect_header_error("estimate.x truth.x P.1.1", "separated by blanks where ',' is expected");
  expect_header_error("0.1,3.2,-1e-3", "there is no header: its first line is numbers; accepted are run");
  expect_header_error(",estimate.x,truth.x,P.1.1", "a column has no name: is it the index of pandas");
  expect_header_error(R"({"estimate.x":1,"truth.x":1,"P.1.1":1})", "JSON is not read");
  expect_header_error("estimate.x;truth.x,P.1.1", "nothing to judge");
}

TEST(FilterLogHeaderLine, marks_at_the_wrong_places_are_refused) {
  const std::string S3 = ",S.1.1,S.1.2,S.1.3,S.2.2,S.2.3,S.3.3";
  for (const char* innovations :
       {"innovation.1:next,innovation.2:next,innovation.3:next",
        "innovation.1,innovation.2,innovation.3:next", "innovation.1,innovation.2:next,innovation.3",
        "innovation.1:next,innovation.2,innovation.3"}) {
    expect_header_error(innovations + S3, "columns innovation.i:next: 3 components are not observations");
  }
  EXPECT_EQ(parse_filter_log_header("innovation.1,innovation.2:next,innovation.3:next" + S3)
                .layout.sensors[0]
                .piece,
            1);
}

TEST(FilterLogHeaderLine, units_stand_in_brackets_behind_a_state) {
  const RunLayout layout = parse_filter_log_header(
                               "estimate.v [m/s],estimate.yaw:angle,truth.v,truth.yaw [rad],P.v.v,"
                               "P.v.yaw,P.yaw.yaw")
                               .layout;
  EXPECT_THAT(layout.states, ElementsAre("v", "yaw"));
  EXPECT_THAT(layout.angles, ElementsAre(false, true));
  EXPECT_THAT(layout.units, ElementsAre("m/s", "rad"));
  EXPECT_THAT(parse_filter_log_header("error.a,error.b[V],P.1.1,P.1.2,P.2.2").layout.units,
              ElementsAre("", "V"));
  EXPECT_TRUE(parse_filter_log_header("error.a,P.1.1").layout.units.empty()) << "not known";
  expect_header_error("estimate.v [m/s],truth.v [km/h],P.1.1",
                      "columns estimate.v and truth.v tell two units, [m/s] and [km/h]");
  expect_header_error("truth.v [km/h],estimate.v [m/s],P.1.1", "tell two units, [km/h] and [m/s]");
  expect_header_error("error.yaw:angle [deg],P.1.1", "state 'yaw' is an angle, in 'deg'; an angle is in rad");
  expect_header_error("error.x [m],error.x,P.1.1", "column error.x is there twice");
  expect_header_error("error.x,P.1.1 [m]", "unknown column 'P.1.1 [m]'");
}

TEST(FilterLogHeaderLine, errors_may_stand_for_estimate_and_truth) {
  const FilterLogHeader h = parse_filter_log_header("error.x,error.b.y:angle,P.1.1,P.1.2,P.2.2");
  EXPECT_THAT(h.layout.states, ElementsAre("x", "b.y"));
  EXPECT_THAT(h.layout.angles, ElementsAre(false, true));
  EXPECT_THAT(h.error, ElementsAre(0, 1));
  EXPECT_TRUE(h.layout.has_truth);
  EXPECT_FALSE(h.layout.componentwise);
  expect_header_error("error.x,error.y", "column P.1.1 is missing");
  expect_header_error("error.x,error.x,P.1.1", "column error.x is there twice");
  for (const char* beside : {"truth.x", "estimate.x", "estimate.x,truth.x"}) {
    expect_header_error(std::string("error.x,P.1.1,") + beside, "of each state either the error, or");
  }
}

// An inertial filter has places by difference, and an attitude that has none.
TEST(FilterLogHeaderLine, some_states_may_have_errors_and_others_estimates) {
  const FilterLogHeader h = parse_filter_log_header(
      "truth.x,estimate.x,error.turn:angle,estimate.y,P.1.1,P.1.2,P.1.3,P.2.2,P.2.3,P.3.3,truth.y");
  EXPECT_THAT(h.layout.states, ElementsAre("x", "turn", "y"));
  EXPECT_THAT(h.estimate, ElementsAre(1, -1, 3));
  EXPECT_THAT(h.truth, ElementsAre(0, -1, 10));
  EXPECT_THAT(h.error, ElementsAre(-1, 2, -1));
  EXPECT_TRUE(h.layout.has_truth);
  EXPECT_TRUE(h.layout.componentwise);  // as far as estimates are known
  expect_header_error("error.x,estimate.y,P.1.1,P.1.2,P.2.2", "column truth.y is missing");
}

}  // namespace
}  // namespace credence::internal

#include "montecarlo/worlds/planar/planar_keys.h"

#include <algorithm>

#include "montecarlo/scenario/key_fields.h"
#include "montecarlo/worlds/slam_settings.h"

namespace credence::internal {
namespace {

using W = WorldSettings;
using N = NoiseSettings;
using I = InitialSettings;
constexpr auto kWorld = &Scenario::world;
constexpr auto kNoise = &Scenario::noise;
constexpr auto kInitial = &Scenario::initial;

bool is_unicycle(const Scenario& s) { return s.world.vehicle == VehicleKind::unicycle; }
bool is_steered(const Scenario& s) { return s.world.vehicle != VehicleKind::unicycle; }

constexpr std::string_view kOnlyUnicycle =
    "with world.model = \"planar\" and world.vehicle = \"unicycle\" (bicycle and car have steering_std_deg)";
constexpr std::string_view kOnlySteered =
    "with world.model = \"planar\" and world.vehicle = \"bicycle\" or \"car\" (the unicycle has "
    "turn_rate_std)";

}  // namespace

KeyRow planar_row(std::string_view section, std::string_view name, bool (*accepted)(const Scenario&),
                  std::string_view accepted_when) {
  const std::vector<KeyRow> rows = planar_keys();
  KeyRow row =
      *std::ranges::find_if(rows, [&](const KeyRow& r) { return r.section == section && r.name == name; });
  row.accepted = accepted;
  row.accepted_when = accepted_when;
  return row;
}

std::vector<KeyRow> planar_keys() {
  std::vector<KeyRow> keys = slam_keys();
  keys.insert(
      keys.end(),
      {{"world", "vehicle", "", "motion model; car is the bicycle with the sensor off the axle",
        choice_field<kWorld, &W::vehicle>(VehicleKind::car)},
       {"world", "path", "", "path that the vehicle drives again and again",
        choice_field<kWorld, &W::path>(PathShape::line)},
       {"world", "path_radius", "m", "radius of the circle and of both loops of the eight; half the line",
        real_field<kWorld, &W::path_radius>(Interval::kPositive)},
       {"world", "speed", "m/s", "speed along the path", real_field<kWorld, &W::speed>(Interval::kPositive)},
       {"world", "dt", "s", "time of one step", real_field<kWorld, &W::dt>(Interval::kPositive)},
       {"world", "sensor_min_range", "m", "landmarks nearer than this are not seen",
        real_field<kWorld, &W::sensor_min_range>(Interval::kNotNegative)},
       {"world", "sensor_range", "m", "landmarks farther away are not seen",
        real_field<kWorld, &W::sensor_range>(Interval::kPositive)},
       {"world", "field_of_view_deg", "deg", "full angle of sight, centred on the heading",
        real_field<kWorld, &W::field_of_view_deg>({0.0, 360.0, true, false})},
       {"noise", "speed_std", "m/s", "standard deviation of the speed",
        real_field<kNoise, &N::speed_std>(Interval::kNotNegative)},
       {"noise", "turn_rate_std", "rad/s", "standard deviation of the turn rate",
        real_field<kNoise, &N::turn_rate_std>(Interval::kNotNegative), is_unicycle, kOnlyUnicycle},
       {"noise", "steering_std_deg", "deg", "standard deviation of the steering angle",
        real_field<kNoise, &N::steering_std_deg>(Interval::kNotNegative), is_steered, kOnlySteered},
       {"noise", "range_std", "m", "standard deviation of a measured range",
        real_field<kNoise, &N::range_std>(Interval::kNotNegative)},
       {"noise", "bearing_std_deg", "deg", "standard deviation of a measured bearing",
        real_field<kNoise, &N::bearing_std_deg>(Interval::kNotNegative)},
       {"initial", "position_std", "m", "standard deviation of each coordinate of the vehicle at the start",
        real_field<kInitial, &I::position_std>(Interval::kNotNegative)},
       {"initial", "heading_std_deg", "deg", "standard deviation of the heading at the start",
        real_field<kInitial, &I::heading_std_deg>(Interval::kNotNegative)}});
  return keys;
}

}  // namespace credence::internal

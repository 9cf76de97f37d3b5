#include <cmath>
#include <iostream>

#include "credence/credence.h"

using credence::FunctionModel, credence::Matrix, credence::Vector;

int main() {
  // A target with position and velocity, seen from 50 m beside its line in range (m) and bearing (rad).
  FunctionModel world;
  world.f = [](const Vector& x) { return Vector(Eigen::Vector2d(x[0] + x[1], x[1])); };
  world.h = [](const Vector& x) {
    return Vector(Eigen::Vector2d(std::hypot(x[0], 50.0), std::atan2(50.0, x[0])));
  };
  world.Q = Eigen::Vector2d(1e-3, 1e-2).asDiagonal();
  world.R = Eigen::Vector2d(0.04, 1e-6).asDiagonal();
  world.mean = Eigen::Vector2d(-20.0, 1.0);
  world.P0 = Eigen::Vector2d(0.25, 0.04).asDiagonal();
  world.states = {"position", "velocity"};
  world.measured_angles = {false, true};

  FunctionModel believed = world;
  believed.Q *= 0.5;  // the filter thinks that the target is steadier than it is

  const auto judged = credence::judge_model(world, believed, {.name = "my_filter", .runs = 500, .steps = 50});
  std::cout << judged.text();
  judged.write_report("out");
  return judged.verdict() == credence::Verdict::consistent ? 0 : 1;
}

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace credence::internal {

/// Where runs of logs end, to tell those that end earlier than they should: a filter that failed and left no
/// word of it would count for as much as one that did not.
class RunEnds {
 public:
  /// `can_be_judged`: its rows have states with a truth.
  void begin_run(const std::string& name, bool can_be_judged);
  /// The run that is open has this name after all.
  void rename_run(const std::string& name) { name_ = name; }
  /// `judged`: the row at this step, later than those before it, has states and their truth.
  void add(std::int64_t step, bool judged);
  /// The run that is open said itself that it failed.
  void failed() { open_failed_ = true; }
  /// The run that is open is whole; begin_run ends it, too.
  void end_run();
  /// Adds runs that come after these; the last of both must be ended.
  void merge(const RunEnds& later);

  /// Of runs whose rows go on for long after the last that is judged; and of runs that end early where nine
  /// of ten end at the same step. Empty where there are none.
  std::vector<std::string> sentences() const;

 private:
  /// Runs of one kind.
  struct Group {
    std::int64_t runs = 0;
    std::string first;                      ///< its name
    std::int64_t judged_to = 0, steps = 0;  ///< of the first
    void add(const Group& later);
  };
  static constexpr std::size_t kMostLengths = 1000;

  Group silent_;
  std::map<std::int64_t, Group> by_length_;  ///< empty once there are more than kMostLengths
  bool ragged_ = false;
  std::int64_t runs_ = 0, failed_ = 0;
  // Of the run that is open:
  std::string name_;
  bool open_ = false, open_failed_ = false, can_be_judged_ = false;
  std::int64_t step_ = 0, judged_to_ = 0, longest_gap_ = 0;
};

}  // namespace credence::internal

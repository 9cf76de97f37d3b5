#pragma once

#include <string>
#include <vector>

#include "analysis/calibration/calibration.h"
#include "analysis/evidence/verdicts/judgement.h"
#include "montecarlo/engine/byte_stream.h"

namespace credence::internal {

/// One test on one study.
struct TestResult {
  std::string name;
  Exactness exactness = Exactness::exact;
  double p_value = 1.0;  ///< NaN where a test has no data
};

inline void write_value(ByteWriter& w, const TestResult& result) {
  w.put(result.name);
  w.put(result.exactness);
  w.put(result.p_value);
}

inline void read_value(ByteReader& r, TestResult& result) {
  r.get(result.name);
  r.get(result.exactness);
  r.get(result.p_value);
}

/// How many of the studies a test rejects; one that does not have it does not.
struct AlarmCount {
  const TestResult* test;  ///< of the first study that has it
  std::int64_t alarms = 0;
};

/// Of every test of any study, by its name, in the order in which they first come.
std::vector<AlarmCount> count_alarms(const std::vector<std::vector<TestResult>>& studies, double level);

/// Evidence and the rows that it is of, judged as those of logs are.
struct JudgedRows {
  Calibration calibration;
  Judgement judgement;
};
JudgedRows judge_rows(const Evidence& evidence, CalibrationRecorder& rows, double confidence);

/// Every test that the product makes of this evidence, of which another one of the same kind may lack some:
/// those of the judgement and of errors by claimed σ and by distance, the e-values of the stop rules, all
/// tests together by Holm, and the word.
std::vector<TestResult> shipped_tests(const Evidence& evidence, const Judgement& judgement,
                                      const Calibration& calibration);

}  // namespace credence::internal

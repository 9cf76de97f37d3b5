#include "reports/document/provenance.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace credence::internal {
namespace {

class ProvenanceTest : public testing::Test {
 protected:
  void TearDown() override { unsetenv("SOURCE_DATE_EPOCH"); }
};

TEST_F(ProvenanceTest, TellsVersionMachineAndCommand) {
  const Provenance p = make_provenance("credence run a.toml");
  EXPECT_FALSE(p.version.empty());
  EXPECT_NE(p.machine.find("threads"), std::string::npos);
  EXPECT_EQ(p.command, "credence run a.toml");
  EXPECT_EQ(p.date.size(), std::string("2026-11-22 10:36:26").size());
}

TEST_F(ProvenanceTest, TheDateCanBeGivenForTheSameBytes) {
  setenv("SOURCE_DATE_EPOCH", "1000000000", 1);
  EXPECT_EQ(make_provenance().date, "2001-09-09 01:46:40");
  setenv("SOURCE_DATE_EPOCH", "10 o'clock", 1);
  EXPECT_GT(make_provenance().date, "2026") << "what is no number of seconds is ignored";
}

TEST_F(ProvenanceTest, LeavesOutWhatIsNotKnown) {
  const auto facts =
      provenance_facts({.version = "1.0", .commit = "", .command = "", .date = "", .machine = "m"});
  ASSERT_EQ(facts.size(), 2u);
  EXPECT_EQ(facts[0].second, "Credence 1.0");
  EXPECT_EQ(facts[1].first, "machine");
}

}  // namespace
}  // namespace credence::internal

#include "datasets/logs/truth_files.h"

#include <gmock/gmock.h>

#include <thread>

#include "datasets/data_error.h"
#include "tests/temporary_folder.h"

namespace credence::internal {
namespace {

using ::testing::HasSubstr;

class TruthFilesOfLogs : public ::testing::Test {
 protected:
  std::string truth(const std::string& name, double x) const {
    return folder_.write(name, "1 " + std::to_string(x) + " 0 0 0 0 0 1\n").string();
  }
  TemporaryFolder folder_;
  std::vector<std::filesystem::path> logs_ = {"b.log", "a.log", "c.log"};
};

TEST_F(TruthFilesOfLogs, without_any_there_are_none) {
  EXPECT_TRUE(TruthFiles().empty());
  EXPECT_TRUE(TruthFiles(logs_, {}).empty());
}

TEST_F(TruthFilesOfLogs, one_for_each_goes_by_their_order) {
  const TruthFiles files(logs_, {truth("1", 1), truth("2", 2), truth("3", 3)});
  EXPECT_FALSE(files.empty());
  EXPECT_EQ(files.file_of("a.log"), folder_ / "2");
  EXPECT_EQ(files.of("b.log")->poses.at(0).position.x(), 1.0);
  EXPECT_EQ(files.of("a.log")->poses.at(0).position.x(), 2.0);
  EXPECT_EQ(files.of("c.log")->poses.at(0).position.x(), 3.0);
}

TEST_F(TruthFilesOfLogs, one_for_all_is_read_once) {
  const TruthFiles files(logs_, {truth("all", 4)}), copy = files;
  const auto first = files.of("c.log");
  EXPECT_EQ(first->poses.at(0).position.x(), 4.0);
  EXPECT_EQ(first->file, folder_ / "all");
  truth("all", 5);
  EXPECT_EQ(files.of("a.log"), first);
  EXPECT_EQ(copy.of("b.log"), first) << "by copies as well";
}

TEST_F(TruthFilesOfLogs, one_for_all_may_be_asked_for_by_several_threads) {
  const TruthFiles files(logs_, {truth("all", 4)});
  std::vector<std::shared_ptr<const Trajectory>> got(8);
  std::vector<std::thread> threads;
  for (auto& slot : got) threads.emplace_back([&] { slot = files.of("a.log"); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& slot : got) EXPECT_EQ(slot, got.front());
  EXPECT_NE(got.front(), nullptr);
}

TEST_F(TruthFilesOfLogs, another_number_of_them_is_refused) {
  EXPECT_THAT(
      [&] {
        TruthFiles(logs_, {"x", "y"});
      },
      ::testing::ThrowsMessage<std::invalid_argument>(
          HasSubstr("--truth: 2 files for 3 logs; accepted is one for all, or one for each")));
  EXPECT_THROW(TruthFiles(logs_, {"w", "x", "y", "z"}), std::invalid_argument);
}

TEST_F(TruthFilesOfLogs, a_truth_that_cannot_be_read_is_an_error_each_time) {
  const TruthFiles files(logs_, {(folder_ / "absent").string()});
  EXPECT_THROW(files.of("a.log"), DataError);
  EXPECT_THROW(files.of("b.log"), DataError);
  truth("absent", 6);
  EXPECT_EQ(files.of("a.log")->poses.at(0).position.x(), 6.0);
}

}  // namespace
}  // namespace credence::internal

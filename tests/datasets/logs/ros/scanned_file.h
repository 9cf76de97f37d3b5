#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "datasets/logs/ros/ros_scan.h"
#include "tests/temporary_folder.h"

namespace credence::internal::testing {

/// What the scan of a file hands over.
struct ScannedFile {
  struct Message {
    std::size_t topic;
    double time_s;
    std::string bytes;
  };
  std::vector<RosTopic> topics;
  std::vector<Message> messages;
  std::int64_t bytes = 0;
};

/// Of a file of this name with these bytes.
inline ScannedFile scanned(const RosScan& scan, const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  ScannedFile seen;
  scan(folder.write(name, bytes),
       {.topic =
            [&](std::size_t i, const RosTopic& topic) {
              EXPECT_EQ(i, seen.topics.size());
              seen.topics.push_back(topic);
            },
        .message =
            [&](std::size_t i, double time_s, ByteCursor message) {
              EXPECT_LT(i, seen.topics.size());
              seen.messages.push_back({i, time_s, std::string(message.take_text(message.left()))});
            },
        .advance = [&](std::int64_t count) { seen.bytes += count; }});
  return seen;
}

}  // namespace credence::internal::testing

#include "datasets/logs/ros/ros1_bag.h"

#include <gmock/gmock.h>

#include "datasets/data_error.h"
#include "tests/datasets/logs/byte_writer.h"
#include "tests/datasets/logs/ros/scanned_file.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using testing::ScannedFile;

const std::string kBagStart = "#ROSBAG V2.0\n";

ScannedFile scanned_bag(const std::string& bytes) {
  return testing::scanned(scan_ros1_bag, "log.bag", bytes);
}

std::string bag_sized(const std::string& text) {
  return ByteWriter().add(static_cast<std::uint32_t>(text.size())).text(text).bytes();
}

std::string bag_field(const std::string& name, const std::string& value) {
  return bag_sized(name + "=" + value);
}

template <class T>
std::string bag_number(T value) {
  return ByteWriter().add(value).bytes();
}

std::string bag_record(const std::string& header, const std::string& data) {
  return bag_sized(header) + bag_sized(data);
}

std::string bag_operation(char code) { return bag_field("op", std::string(1, code)); }

std::string bag_connection(std::uint32_t id, const std::string& topic, const std::string& type) {
  return bag_record(bag_operation(7) + bag_field("conn", bag_number(id)) + bag_field("topic", topic),
                    bag_field("topic", topic) + bag_field("type", type) + bag_field("md5sum", "*"));
}

std::string bag_message(std::uint32_t id, std::uint32_t seconds, std::uint32_t nanoseconds,
                        const std::string& data) {
  return bag_record(bag_operation(2) + bag_field("conn", bag_number(id)) +
                        bag_field("time", bag_number(seconds) + bag_number(nanoseconds)),
                    data);
}

std::string bag_chunk(const std::string& records, const std::string& compression, std::size_t size) {
  return bag_record(bag_operation(5) + bag_field("compression", compression) +
                        bag_field("size", bag_number(static_cast<std::uint32_t>(size))),
                    records);
}

std::string bag_header(const std::string& more = "") {
  return bag_record(bag_operation(3) + bag_field("index_pos", std::string(8, '\0')) + more, "   ");
}

void expect_bag_fails(const std::string& records, const std::string& problem) {
  EXPECT_THAT([&] { scanned_bag(kBagStart + records); },
              ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
}

TEST(Ros1Bag, messages_come_in_their_order_with_topic_time_and_bytes) {
  const std::string records =
      bag_connection(9, "/odom", "nav_msgs/Odometry") + bag_message(9, 5, 250'000'000, "a");
  const std::string bag = kBagStart + bag_header() + bag_chunk(records, "none", records.size()) +
                          bag_connection(0, "/tf", "tf/tfMessage") +
                          bag_message(0, 4'000'000'000U, 500'000'000, std::string("\0b", 2));
  const ScannedFile seen = scanned_bag(bag);
  ASSERT_EQ(seen.topics.size(), 2U);
  EXPECT_EQ(seen.topics[0].name, "/odom");
  EXPECT_EQ(seen.topics[0].type, "nav_msgs/Odometry");
  EXPECT_EQ(seen.topics[0].encoding, RosTopic::Encoding::ros1);
  EXPECT_EQ(seen.topics[1].name, "/tf");
  ASSERT_EQ(seen.messages.size(), 2U);
  EXPECT_EQ(seen.messages[0].topic, 0U);
  EXPECT_EQ(seen.messages[0].time_s, 5.25);
  EXPECT_EQ(seen.messages[0].bytes, "a");
  EXPECT_EQ(seen.messages[1].topic, 1U);
  EXPECT_EQ(seen.messages[1].time_s, 4e9 + 0.5);
  EXPECT_EQ(seen.messages[1].bytes, std::string("\0b", 2));
  EXPECT_EQ(seen.bytes, std::ssize(bag) - 13) << "all but the first line";
}

TEST(Ros1Bag, connections_of_the_index_are_not_announced_again) {
  const std::string connection = bag_connection(0, "/t", "a/B");
  const ScannedFile seen = scanned_bag(kBagStart + connection + bag_message(0, 1, 0, "x") + connection);
  EXPECT_EQ(seen.topics.size(), 1U);
}

TEST(Ros1Bag, records_of_the_index_are_passed_over_in_the_file_and_in_chunks) {
  const std::string index = bag_record(bag_operation(4) + bag_field("ver", "x"), "whatever") +
                            bag_record(bag_operation(6), "") + bag_record(bag_operation(0x7f), "");
  const std::string records = bag_connection(0, "/t", "a/B") + index + bag_message(0, 1, 0, "x");
  EXPECT_EQ(
      scanned_bag(kBagStart + index + bag_chunk(records, "none", records.size()) + index).messages.size(),
      1U);
}

TEST(Ros1Bag, a_value_may_hold_an_equals_sign_and_the_order_of_fields_is_free) {
  const ScannedFile seen =
      scanned_bag(kBagStart + bag_record(bag_field("topic", "/a=b") + bag_field("conn", bag_number(7U)) +
                                             bag_operation(7),
                                         bag_field("type", "x/Y=Z")));
  ASSERT_EQ(seen.topics.size(), 1U);
  EXPECT_EQ(seen.topics[0].name, "/a=b");
  EXPECT_EQ(seen.topics[0].type, "x/Y=Z");
}

TEST(Ros1Bag, a_bag_without_records_holds_nothing) {
  EXPECT_TRUE(scanned_bag(kBagStart).topics.empty());
  EXPECT_TRUE(scanned_bag(kBagStart + bag_chunk("", "none", 0)).topics.empty());
}

TEST(Ros1Bag, only_version_2_is_a_bag) {
  EXPECT_TRUE(begins_as_ros1_bag("#ROSBAG V2.0\nrest"));
  EXPECT_FALSE(begins_as_ros1_bag("#ROSBAG V1.2\nrest"));
  EXPECT_FALSE(begins_as_ros1_bag("#ROSBAG V2.0"));
  EXPECT_THROW(scanned_bag("#ROSBAG V1.2\nrest"), DataError);
  EXPECT_THROW(scanned_bag(""), DataError);
}

TEST(Ros1Bag, an_encrypted_bag_is_refused) {
  expect_bag_fails(bag_header(bag_field("encryptor", "rosbag/AesCbcEncryptor")), "byte 13: an encrypted bag");
  EXPECT_TRUE(scanned_bag(kBagStart + bag_header(bag_field("encryptor", ""))).topics.empty());
}

TEST(Ros1Bag, malformed_headers_are_errors_with_the_byte) {
  expect_bag_fails(bag_record(bag_sized("op"), ""), "byte 21: a header field without '=': corrupted");
  expect_bag_fails(bag_record(bag_field("ver", "x"), ""), "byte 17: a header without 'op'");
  expect_bag_fails(bag_record("", ""), "a header without 'op'");
  expect_bag_fails(bag_record(bag_field("op", ""), ""), "1 bytes are needed here and 0 are left");
  expect_bag_fails(bag_record("\x01", ""), "are left: cut off, or corrupted");
  expect_bag_fails(bag_record(bag_number(0xffffffffU), ""), "are left: cut off, or corrupted");
  expect_bag_fails(bag_record(bag_operation(7) + bag_field("conn", bag_number(1U)), bag_field("type", "a/B")),
                   "a header without 'topic'");
  expect_bag_fails(
      bag_record(bag_operation(7) + bag_field("conn", bag_number(1U)) + bag_field("topic", "/t"), ""),
      "a header without 'type'");
  expect_bag_fails(bag_record(bag_operation(7) + bag_field("conn", "ab"), ""),
                   "4 bytes are needed here and 2 are");
  expect_bag_fails(bag_connection(1, "/t", "a/B") + bag_message(2, 0, 0, ""),
                   "a message of connection 2 that nobody announced");
}

TEST(Ros1Bag, malformed_chunks_are_errors_with_the_byte) {
  const std::string records = bag_connection(0, "/t", "a/B") + bag_message(0, 1, 0, "data");
  expect_bag_fails(bag_chunk(records, "zstd", records.size()),
                   "packed with 'zstd'; read are none, bz2 and lz4");
  expect_bag_fails(bag_chunk(records, "none", records.size() + 1), "127 bytes where 128 are said");
  expect_bag_fails(bag_chunk(records, "bz2", records.size()), "bz2 ");
  expect_bag_fails(bag_chunk(records, "lz4", 0xffffffffU), "at most 1 GiB is read at once");
  const std::string cut = records.substr(0, records.size() - 1);
  expect_bag_fails(bag_chunk(cut, "none", cut.size()), "of the chunk at byte ");
}

TEST(Ros1Bag, lengths_beyond_the_file_are_errors_with_the_byte) {
  expect_bag_fails(bag_number(0xffffffffU) + "rest", "the length of a record of 4 bytes begins here");
  expect_bag_fails(bag_sized(bag_operation(2)) + bag_number(0xffffffffU) + "rest",
                   "byte 13: a record of 4294967311 bytes begins here and the file ends at byte");
}

TEST(Ros1Bag, a_record_that_is_passed_over_must_be_whole_too) {
  expect_bag_fails(bag_sized(bag_operation(4)) + bag_number(10U) + "rest",
                   "byte 13: a record of 26 bytes begins here and the file ends at byte");
}

TEST(Ros1Bag, a_cut_is_an_error_unless_it_falls_between_records) {
  const std::string first = bag_connection(0, "/t", "a/B"), second = bag_message(0, 1, 0, "data");
  const std::string whole = kBagStart + first + second;
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    if (cut == kBagStart.size() || cut == kBagStart.size() + first.size()) {
      EXPECT_NO_THROW(scanned_bag(whole.substr(0, cut)));
    } else {
      EXPECT_THROW(scanned_bag(whole.substr(0, cut)), DataError) << cut;
    }
  }
}

TEST(Ros1Bag, no_changed_byte_does_anything_else_than_fail_with_the_file) {
  const std::string records = bag_connection(0, "/t", "a/B") + bag_message(0, 1, 0, "data");
  const std::string whole = kBagStart + bag_header() + bag_chunk(records, "none", records.size()) + records;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int flip : {0x01, 0x40, 0x80, 0xff}) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ flip);
      try {
        scanned_bag(flipped);
      } catch (const DataError& error) {
        EXPECT_EQ(error.file().filename(), "log.bag");
      }
    }
  }
}

}  // namespace
}  // namespace credence::internal

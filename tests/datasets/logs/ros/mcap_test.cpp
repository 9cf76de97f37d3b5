#include "datasets/logs/ros/mcap.h"

#include <gmock/gmock.h>
#include <zlib.h>

#include "datasets/data_error.h"
#include "tests/datasets/logs/byte_writer.h"
#include "tests/datasets/logs/ros/scanned_file.h"

namespace credence::internal {
namespace {

using testing::ByteWriter;
using ::testing::HasSubstr;
using testing::ScannedFile;

const std::string kMcapStart("\x89MCAP0\r\n", 8);

ScannedFile scanned_mcap(const std::string& bytes) { return testing::scanned(scan_mcap, "log.mcap", bytes); }

std::string mcap_record(int opcode, const std::string& body) {
  return ByteWriter()
      .add(static_cast<std::uint8_t>(opcode))
      .add(static_cast<std::uint64_t>(body.size()))
      .text(body)
      .bytes();
}

std::string mcap_string(const std::string& text) {
  return ByteWriter().add(static_cast<std::uint32_t>(text.size())).text(text).bytes();
}

std::string mcap_schema(std::uint16_t id, const std::string& type) {
  return mcap_record(
      3, ByteWriter().add(id).bytes() + mcap_string(type) + mcap_string("ros2msg") + mcap_string(""));
}

std::string mcap_channel(std::uint16_t id, std::uint16_t schema, const std::string& topic,
                         const std::string& encoding) {
  return mcap_record(4, ByteWriter().add(id).add(schema).bytes() + mcap_string(topic) +
                            mcap_string(encoding) + mcap_string(""));
}

std::string mcap_message(std::uint16_t channel, std::uint64_t logged_ns, const std::string& data) {
  return mcap_record(5, ByteWriter()
                            .add(channel)
                            .add<std::uint32_t>(9)
                            .add(logged_ns)
                            .add<std::uint64_t>(77)  // published
                            .text(data)
                            .bytes());
}

std::string mcap_chunk(const std::string& records, const std::string& compression, std::uint32_t checksum,
                       std::uint64_t size) {
  return mcap_record(6, ByteWriter()
                            .add<std::uint64_t>(0)
                            .add<std::uint64_t>(0)
                            .add(size)
                            .add(checksum)
                            .text(mcap_string(compression))
                            .add(static_cast<std::uint64_t>(records.size()))
                            .text(records)
                            .bytes());
}

const std::string kMcapEnd = mcap_record(0x0f, std::string(4, '\0'));

std::string mcap_of(const std::string& records) { return kMcapStart + records + kMcapEnd; }

std::uint32_t crc32_of(const std::string& bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<z_size_t>(bytes.size())));
}

void expect_mcap_fails(const std::string& bytes, const std::string& problem) {
  EXPECT_THAT([&] { scanned_mcap(bytes); }, ::testing::ThrowsMessage<DataError>(HasSubstr(problem)));
}

TEST(Mcap, messages_come_in_their_order_with_topic_time_and_bytes) {
  const ScannedFile seen = scanned_mcap(
      mcap_of(mcap_schema(7, "nav_msgs/msg/Odometry") + mcap_channel(300, 7, "/odom", "cdr") +
              mcap_channel(2, 0, "/raw", "json") + mcap_message(2, 1'500'000'000, "later") +
              mcap_message(300, 1'250'000'000, std::string("a\0b", 3)) + mcap_message(2, 0, "")));
  ASSERT_EQ(seen.topics.size(), 2U);
  EXPECT_EQ(seen.topics[0].name, "/odom");
  EXPECT_EQ(seen.topics[0].type, "nav_msgs/Odometry");
  EXPECT_EQ(seen.topics[0].encoding, RosTopic::Encoding::cdr);
  EXPECT_EQ(seen.topics[1].type, "");
  EXPECT_EQ(seen.topics[1].encoding, RosTopic::Encoding::other);
  ASSERT_EQ(seen.messages.size(), 3U);
  EXPECT_EQ(seen.messages[0].topic, 1U);
  EXPECT_EQ(seen.messages[0].time_s, 1.5);
  EXPECT_EQ(seen.messages[1].topic, 0U);
  EXPECT_EQ(seen.messages[1].time_s, 1.25);
  EXPECT_EQ(seen.messages[1].bytes, std::string("a\0b", 3));
  EXPECT_EQ(seen.messages[2].bytes, "");
}

TEST(Mcap, types_are_named_without_the_msg_of_ros_2) {
  const auto type = [](const std::string& written) {
    return scanned_mcap(mcap_of(mcap_schema(1, written) + mcap_channel(1, 1, "/t", "ros1")))
        .topics.at(0)
        .type;
  };
  EXPECT_EQ(type("geometry_msgs/msg/PoseStamped"), "geometry_msgs/PoseStamped");
  EXPECT_EQ(type("geometry_msgs/PoseStamped"), "geometry_msgs/PoseStamped");
  EXPECT_EQ(type("msg/msg/msg"), "msg/msg");
}

TEST(Mcap, a_channel_that_is_announced_again_is_one_topic) {
  const std::string channel = mcap_channel(1, 0, "/t", "ros1");
  const ScannedFile seen =
      scanned_mcap(mcap_of(channel + mcap_message(1, 0, "a") + channel + mcap_message(1, 0, "b")));
  ASSERT_EQ(seen.topics.size(), 1U);
  EXPECT_EQ(seen.topics[0].encoding, RosTopic::Encoding::ros1);
  EXPECT_EQ(seen.messages.size(), 2U);
}

TEST(Mcap, what_is_not_known_is_passed_over_and_nothing_is_read_behind_the_end) {
  const std::string file = kMcapStart + mcap_record(0x01, "header") +
                           mcap_record(0x09, std::string(3 << 20, 'x')) + mcap_record(0x80, "of a user") +
                           mcap_channel(1, 0, "/t", "cdr") + mcap_message(1, 0, "a") + kMcapEnd;
  const ScannedFile seen = scanned_mcap(file + mcap_message(1, 0, "b") + "no record");
  EXPECT_EQ(seen.messages.size(), 1U);
  EXPECT_EQ(seen.bytes, std::ssize(file) - 8) << "all but the magic";
  // A footer ends it as well.
  EXPECT_EQ(scanned_mcap(kMcapStart + mcap_record(0x02, std::string(20, '\0')) + "rest").messages.size(), 0U);
}

// What the format's own conformance tests hold of a file without data: all before its end, from the magic on.
TEST(Mcap, all_data_have_a_checksum) {
  const auto end = [](std::uint32_t checksum) {
    return mcap_record(0x0f, ByteWriter().add(checksum).bytes());
  };
  const std::string header = kMcapStart + mcap_record(0x01, std::string(8, '\0'));
  EXPECT_NO_THROW(scanned_mcap(header + end(3959079795U)));
  expect_mcap_fails(header + end(3959079794U), "byte 25: data with a checksum that is not their own");
  // Longer than what is read at once.
  std::string data = header + mcap_channel(1, 0, "/t", "cdr") + mcap_message(1, 0, std::string(3 << 20, 'x'));
  const std::uint32_t checksum = crc32_of(data);
  EXPECT_EQ(scanned_mcap(data + end(checksum)).messages.size(), 1U);
  data[2 << 20] = 'y';
  expect_mcap_fails(data + end(checksum), "corrupted");
  EXPECT_EQ(scanned_mcap(data + end(0)).messages.size(), 1U) << "0: there is none";
}

TEST(Mcap, a_chunk_holds_what_its_records_hold) {
  const std::string records = mcap_channel(1, 0, "/t", "cdr") + mcap_message(1, 2'000'000'000, "in");
  for (const std::uint32_t checksum : {0U, crc32_of(records)}) {  // 0: there is none
    const ScannedFile seen =
        scanned_mcap(mcap_of(mcap_chunk(records, "", checksum, records.size()) + mcap_message(1, 0, "out")));
    ASSERT_EQ(seen.messages.size(), 2U);
    EXPECT_EQ(seen.messages[0].bytes, "in");
    EXPECT_EQ(seen.messages[0].time_s, 2.0);
    EXPECT_EQ(seen.messages[1].bytes, "out");
  }
  EXPECT_EQ(scanned_mcap(mcap_of(mcap_chunk("", "", 0, 0))).topics.size(), 0U);
}

TEST(Mcap, a_corrupted_chunk_is_an_error_with_its_place) {
  const std::string records = mcap_channel(1, 0, "/t", "cdr") + mcap_message(1, 0, "in");
  const std::uint64_t size = records.size();
  const auto fails = [&](const std::string& chunk, const std::string& problem) {
    expect_mcap_fails(mcap_of(chunk), problem);
  };
  fails(mcap_chunk(records, "", crc32_of(records) ^ 1U, size),
        "byte 17: a chunk with a checksum that is not");
  fails(mcap_chunk(records, "brotli", 0, size), "packed with 'brotli'; read are lz4 and zstd");
  fails(mcap_chunk(records, "", 0, size + 1), "63 bytes where 64 are said");
  fails(mcap_chunk(records, "zstd", 0, size), "zstd cannot be unpacked");
  fails(mcap_chunk(records, "lz4", 0, ~std::uint64_t{0}), "at most 1 GiB");
  fails(mcap_chunk(mcap_chunk("", "", 0, 0), "", 0, 9 + 40), "a chunk within a chunk");
  const std::string cut = records.substr(0, records.size() - 1);
  fails(mcap_chunk(cut, "", 0, cut.size()), "of the chunk at byte 17");
}

TEST(Mcap, lengths_beyond_the_file_are_errors_with_the_byte) {
  const auto claim = [](std::uint8_t opcode, std::uint64_t size) {
    return kMcapStart + ByteWriter().add(opcode).add(size).text("rest").bytes();
  };
  for (const std::uint8_t opcode : {std::uint8_t{1}, std::uint8_t{5}, std::uint8_t{6}, std::uint8_t{15}}) {
    expect_mcap_fails(claim(opcode, 5), "log.mcap:byte 8: a record of 5 bytes begins here");
    expect_mcap_fails(claim(opcode, ~std::uint64_t{0}), "byte 8: a record of 18446744073709551615 bytes");
    expect_mcap_fails(claim(opcode, ~std::uint64_t{0} - 16), "byte 8: a record of");
  }
  std::string channel = mcap_channel(1, 0, "/t", "cdr");
  channel[9 + 4 + 3] = '\x7f';  // a topic of two gigabytes
  expect_mcap_fails(mcap_of(channel), "are left: cut off, or corrupted");
  expect_mcap_fails(mcap_of(mcap_record(5, "short")), "are left: cut off, or corrupted");
}

TEST(Mcap, a_message_of_a_channel_that_nobody_announced_is_an_error) {
  expect_mcap_fails(mcap_of(mcap_message(3, 0, "a")), "a message of channel 3 that nobody announced");
}

TEST(Mcap, is_told_by_its_magic_alone) {
  EXPECT_TRUE(begins_as_mcap(kMcapStart));
  EXPECT_FALSE(begins_as_mcap(kMcapStart.substr(0, 7)));
  EXPECT_FALSE(begins_as_mcap("MCAP0"));
  expect_mcap_fails("", "the magic of an MCAP");
  expect_mcap_fails("\x89MCAP1\r\n" + kMcapEnd, "byte 0: is no MCAP");
  expect_mcap_fails(kMcapStart, "a record header");
}

TEST(Mcap, no_cut_and_no_changed_byte_does_anything_else_than_fail_with_the_file) {
  const std::string records =
      mcap_schema(1, "a/msg/B") + mcap_channel(1, 1, "/t", "cdr") + mcap_message(1, 5, "data");
  const std::string whole = mcap_of(mcap_chunk(records, "", 0, records.size()) + mcap_message(1, 6, "more"));
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    EXPECT_THROW(scanned_mcap(whole.substr(0, cut)), DataError) << cut;
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int flip : {0x01, 0x40, 0x80, 0xff}) {
      std::string flipped = whole;
      flipped[at] = static_cast<char>(flipped[at] ^ flip);
      try {
        scanned_mcap(flipped);
      } catch (const DataError& error) {
        EXPECT_EQ(error.file().filename(), "log.mcap");
      }
    }
  }
}

}  // namespace
}  // namespace credence::internal

#include "montecarlo/engine/rank_messages.h"

#include <gtest/gtest.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace credence::internal {
namespace {

RankMessage full_message() {
  RankMessage m;
  m.kind = RankMessage::Kind::records;
  m.phase = 7;
  m.identity = 0xfedcba9876543210U;
  m.range = {40, 50};
  m.text = std::string("a\0b", 3);
  m.records = {{41, {std::byte{1}, std::byte{2}}}, {42, {}}, {9'000'000'000, std::vector<std::byte>(300)}};
  return m;
}

void expect_same_message(const RankMessage& a, const RankMessage& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.phase, b.phase);
  EXPECT_EQ(a.identity, b.identity);
  EXPECT_EQ(std::memcmp(&a.range, &b.range, sizeof a.range), 0);
  EXPECT_EQ(a.text, b.text);
  ASSERT_EQ(a.records.size(), b.records.size());
  for (std::size_t i = 0; i < a.records.size(); ++i) {
    EXPECT_EQ(a.records[i].task, b.records[i].task);
    EXPECT_EQ(a.records[i].bytes, b.records[i].bytes);
  }
}

std::string message_refusal(const std::vector<std::byte>& bytes) {
  try {
    rank_message_from_bytes(bytes);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RankMessage, comes_back_as_it_was_sent) {
  for (const RankMessage& m : {full_message(), RankMessage(), RankMessage{.kind = RankMessage::Kind::bye}}) {
    expect_same_message(rank_message_from_bytes(to_bytes(m)), m);
  }
}

TEST(RankMessage, is_refused_when_it_is_cut_or_goes_on) {
  std::vector<std::byte> bytes = to_bytes(full_message());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(message_refusal({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}), "accepted")
        << size;
  }
  bytes.push_back({});
  EXPECT_EQ(message_refusal(bytes), "a message of another rank is longer than it says");
}

// Number and bytes of a record are under its checksum; of the rest the format and the kind are known.
TEST(RankMessage, is_refused_when_a_record_changed_on_its_way) {
  RankMessage m;
  m.kind = RankMessage::Kind::records;
  const std::size_t head = to_bytes(m).size();
  m.records = {{5, {std::byte{1}, std::byte{2}, std::byte{3}}}};
  const std::vector<std::byte> sent = to_bytes(m);
  for (std::size_t i = head; i < sent.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<std::byte> bytes = sent;
      bytes[i] ^= std::byte{1} << bit;
      EXPECT_NE(message_refusal(bytes), "accepted") << "byte " << i << ", bit " << bit;
    }
  }
  std::vector<std::byte> changed = sent;
  changed.back() ^= std::byte{1};
  EXPECT_EQ(message_refusal(changed), "a message of another rank is damaged");
}

TEST(RankMessage, of_another_format_or_kind_is_refused) {
  std::vector<std::byte> bytes = to_bytes(full_message());
  bytes[0] ^= std::byte{1};
  EXPECT_EQ(message_refusal(bytes), "a message of another rank has another format");
  bytes = to_bytes(full_message());
  bytes[4] = std::byte{8};
  EXPECT_EQ(message_refusal(bytes), "a message of another rank is of an unknown kind");
  EXPECT_EQ(message_refusal({}), "a message of another rank ends too early");
}

TEST(RankMessage, a_count_that_cannot_be_allocates_nothing) {
  std::vector<std::byte> bytes = to_bytes(RankMessage());
  for (std::size_t i = bytes.size() - 8; i < bytes.size(); ++i) bytes[i] = std::byte{0xff};
  EXPECT_EQ(message_refusal(bytes), "a message of another rank is shorter than it says");
}

}  // namespace
}  // namespace credence::internal

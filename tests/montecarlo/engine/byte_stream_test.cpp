#include "montecarlo/engine/byte_stream.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace credence::internal {
namespace {

TEST(ByteStream, WhatWasPutIsReadBack) {
  ByteWriter writer;
  writer.put(true);
  writer.put(0.1);
  writer.put(std::string_view("a name"));
  writer.put(std::vector<std::int64_t>{3, -1});
  const std::vector<std::byte> bytes = writer.take();
  ByteReader reader(bytes, "the test");
  bool yes = false;
  std::string text;
  std::vector<std::int64_t> numbers;
  reader.get(yes);
  EXPECT_TRUE(yes);
  EXPECT_EQ(reader.get<double>(), 0.1);
  reader.get(text);
  EXPECT_EQ(text, "a name");
  reader.get(numbers);
  EXPECT_EQ(numbers, (std::vector<std::int64_t>{3, -1}));
  reader.require_end();
}

TEST(ByteStream, AYesOrNoIsOneOfTwoBytes) {
  const std::array bytes = {std::byte{0}, std::byte{8}};
  ByteReader reader(bytes, "the test");
  bool value = true;
  reader.get(value);
  EXPECT_FALSE(value);
  EXPECT_THROW(reader.get(value), std::runtime_error);
}

TEST(ByteStream, CountsThatTheRestCannotHoldAreRefused) {
  ByteWriter writer;
  writer.put(std::uint64_t{1} << 60);
  const std::vector<std::byte> bytes = writer.take();
  std::string text;
  std::vector<double> numbers;
  EXPECT_THROW(ByteReader(bytes, "the test").get(text), std::runtime_error);
  EXPECT_THROW(ByteReader(bytes, "the test").get(numbers), std::runtime_error);
  EXPECT_THROW(ByteReader(bytes, "the test").require_end(), std::runtime_error);
  std::vector<double> few;
  ByteReader(bytes, "the test").reserve(few, 1000);
  EXPECT_EQ(few.capacity(), 1);  // 8 bytes are left
  EXPECT_THROW(ByteReader(std::span(bytes).first(7), "the test").get<double>(), std::runtime_error);
}

}  // namespace
}  // namespace credence::internal

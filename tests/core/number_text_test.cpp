#include "core/number_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace credence::internal {
namespace {

TEST(NumberText, RoundsToSignificantDigits) {
  EXPECT_EQ(number_text(0.383847064), "0.3838");
  EXPECT_EQ(number_text(12.705589127), "12.71");
  EXPECT_EQ(number_text(2.0), "2.000");
  EXPECT_EQ(number_text(0.00123456, 3), "0.00123");
  EXPECT_EQ(number_text(3.14159, 1), "3");
}

TEST(NumberText, KeepsTheIntegerPart) {
  EXPECT_EQ(number_text(123456.7, 3), "123457");
  EXPECT_EQ(number_text(1767.0), "1767");
}

TEST(NumberText, CarriesIntoTheNextDecade) {
  EXPECT_EQ(number_text(9.99996), "10.00");
  EXPECT_EQ(number_text(0.99999, 3), "1.00");
  EXPECT_EQ(number_text(9999999.9, 3), "1.00e7");
}

TEST(NumberText, ShortHasNoZerosBehindAndTheSameMinus) {
  EXPECT_EQ(short_text(0.25), "0.25");
  EXPECT_EQ(short_text(4.0), "4");
  EXPECT_EQ(short_text(1e-9), "1e−9");
  EXPECT_EQ(short_text(-2.5e7), "−2.5e7");
  EXPECT_EQ(short_text(-std::numeric_limits<double>::infinity()), "−∞");
}

TEST(NumberText, FixedHasNoSignOfZero) {
  EXPECT_EQ(fixed_text(1.005e3, 2), "1005.00");
  EXPECT_EQ(fixed_text(-0.046, 2), "−0.05");
  EXPECT_EQ(fixed_text(-0.004, 2), "0.00");
  EXPECT_EQ(fixed_text(-0.0, 0), "0");
}

TEST(NumberText, TakesAnExponentForExtremes) {
  EXPECT_EQ(number_text(13000000.0), "1.300e7");
  EXPECT_EQ(number_text(1.23456e-12, 3), "1.23e−12");
  EXPECT_EQ(number_text(-4.5e300, 2), "−4.5e300");
  EXPECT_EQ(number_text(std::numeric_limits<double>::denorm_min(), 2), "4.9e−324");
}

TEST(NumberText, NamesWhatIsNoNumber) {
  EXPECT_EQ(number_text(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(number_text(std::numeric_limits<double>::infinity()), "∞");
  EXPECT_EQ(number_text(-std::numeric_limits<double>::infinity()), "−∞");
}

TEST(NumberText, ZeroHasNoSign) {
  EXPECT_EQ(number_text(0.0), "0.000");
  EXPECT_EQ(number_text(-0.0), "0.000");
}

TEST(NumberText, LimitsTheDigitsToWhatADoubleHolds) {
  EXPECT_EQ(number_text(0.5, 0), "0.5");
  EXPECT_EQ(number_text(0.1, 1000), "0.10000000000000001");
}

TEST(DurationText, TakesTheUnitThatSuits) {
  EXPECT_EQ(duration_text(0.0), "0 s");
  EXPECT_EQ(duration_text(1.637e-9), "1.64 ns");
  EXPECT_EQ(duration_text(2.5e-6), "2.50 µs");
  EXPECT_EQ(duration_text(0.0123), "12.3 ms");
  EXPECT_EQ(duration_text(90.0), "90.0 s");
  EXPECT_EQ(duration_text(192.0, 2), "3.2 min");
  EXPECT_EQ(duration_text(9000.0, 2), "2.5 h");
}

TEST(NumberText, BoundsThatThreeDigitsDoNotTellApartHaveMore) {
  EXPECT_EQ(interval_text(1.00312, 1.00124, 1.00488), "1.003 (1.001 … 1.005)");
  EXPECT_EQ(interval_text(1.06, 1.02, 1.11), "1.06 (1.02 … 1.11)");
  EXPECT_EQ(interval_text(1.0000004, 1.0000001, 1.0000007, 4), "1.000000 (1.000000 … 1.000001)");
  EXPECT_EQ(interval_text(2.0, 2.0, 2.0), "2.00 (2.00 … 2.00)");
}

}  // namespace
}  // namespace credence::internal

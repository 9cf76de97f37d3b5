#include "datasets/logs/line_reader.h"

#include <cstring>

#include "core/stop_point.h"
#include "datasets/data_error.h"

namespace credence::internal {
namespace {

constexpr std::size_t kFirstBuffer = std::size_t{1} << 16;
constexpr std::size_t kLongestLine = std::size_t{1} << 24;

}  // namespace

void refuse_utf16(const std::filesystem::path& file, std::string_view beginning) {
  if (!beginning.starts_with("\xff\xfe") && !beginning.starts_with("\xfe\xff")) return;
  throw DataError(file, "", "is text of UTF-16; save it as UTF-8 (iconv -f UTF-16 -t UTF-8 FILE)");
}

LineReader::LineReader(std::filesystem::path file)
    : file_(std::move(file)), in_(open_data(file_)), buffer_(kFirstBuffer + kReadable) {
  fill();
  refuse_utf16(file_, {buffer_.data(), end_});
  begin_ = std::string_view(buffer_.data(), end_).starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
}

bool LineReader::fill() {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  if (end_ + kReadable == buffer_.size()) {
    if (end_ >= kLongestLine) {
      throw DataError(file_, std::to_string(line_number_ + 1), "the line is longer than 16 MB");
    }
    buffer_.resize(2 * end_ + kReadable);
  }
  in_.read(buffer_.data() + end_, static_cast<std::streamsize>(buffer_.size() - kReadable - end_));
  if (in_.bad()) throw DataError(file_, "", "cannot be read");
  const auto count = static_cast<std::size_t>(in_.gcount());
  end_ += count;
  bytes_read_ += in_.gcount();
  return count > 0;
}

bool LineReader::next(std::string_view& line) {
  stop_point();
  std::size_t searched = begin_;
  for (;;) {
    const void* newline = std::memchr(buffer_.data() + searched, '\n', end_ - searched);
    if (newline != nullptr) {
      const char* first = buffer_.data() + begin_;
      const auto length = static_cast<std::size_t>(static_cast<const char*>(newline) - first);
      begin_ += length + 1;
      ++line_number_;
      line = {first, length};
      if (line.ends_with('\r')) line.remove_suffix(1);
      return true;
    }
    const std::size_t waiting = end_ - begin_;
    if (!fill()) break;
    searched = waiting;
  }
  if (begin_ == end_) return false;
  ++line_number_;
  if (std::memchr(buffer_.data() + begin_, '\r', end_ - begin_ - 1) != nullptr)
    fail("lines end with CR alone, as on old Macs: LF, or CR LF, is read");
  fail("the last line has no end: cut off? (end it with a line break)");
}

void LineReader::fail(const std::string& problem) const {
  throw DataError(file_, std::to_string(line_number_), problem);
}

}  // namespace credence::internal

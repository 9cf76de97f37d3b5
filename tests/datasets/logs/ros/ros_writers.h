#pragma once

#include <bzlib.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/logs/trajectory.h"
#include "tests/datasets/logs/byte_writer.h"

/// @file
/// Writes messages and bags of ROS as their specifications say, for the tests of the readers.

namespace credence::internal::testing {

/// A message in one of the serialisations.
class MessageWriter {
 public:
  enum class Kind { ros1, cdr, cdr_big_endian, cdr2 };

  explicit MessageWriter(Kind kind)
      : kind_(kind), bytes_(kind == Kind::cdr_big_endian ? std::endian::big : std::endian::little) {
    if (kind == Kind::ros1) return;
    const char representation = kind == Kind::cdr ? 1 : kind == Kind::cdr2 ? 7 : 0;
    bytes_.text(std::string{0, representation, 0, 0});
  }

  template <class T>
  MessageWriter& add(T value) {
    if (kind_ != Kind::ros1) {
      const std::size_t alignment = kind_ == Kind::cdr2 ? std::min<std::size_t>(4, sizeof(T)) : sizeof(T);
      while ((bytes_.bytes().size() - 4) % alignment != 0) bytes_.text(std::string(1, '\xaa'));
    }
    bytes_.add(value);
    return *this;
  }
  MessageWriter& text(const std::string& text) {
    add(static_cast<std::uint32_t>(text.size() + (kind_ == Kind::ros1 ? 0 : 1)));
    bytes_.text(text);
    if (kind_ != Kind::ros1) bytes_.text(std::string(1, '\0'));
    return *this;
  }
  MessageWriter& header(double time_s, const std::string& frame) {
    if (kind_ == Kind::ros1) add<std::uint32_t>(5);
    const auto seconds = static_cast<std::uint32_t>(time_s);
    add(seconds).add(static_cast<std::uint32_t>(std::lround((time_s - seconds) * 1e9)));
    return text(frame);
  }
  MessageWriter& vector(const Eigen::Vector3d& v) { return add(v.x()).add(v.y()).add(v.z()); }
  MessageWriter& pose(const SpatialPose& pose) {
    const Eigen::Quaterniond& q = pose.orientation;
    return vector(pose.position).add(q.x()).add(q.y()).add(q.z()).add(q.w());
  }
  template <class Derived>
  MessageWriter& matrix(const Eigen::MatrixBase<Derived>& m) {
    for (Index i = 0; i < m.rows(); ++i) {
      for (Index j = 0; j < m.cols(); ++j) add(m(i, j));
    }
    return *this;
  }
  const std::string& bytes() const { return bytes_.bytes(); }

 private:
  Kind kind_;
  ByteWriter bytes_;
};

/// A bag before it is written.
struct BagContent {
  struct Topic {
    std::string name, type;  ///< "nav_msgs/Odometry"
  };
  struct Message {
    std::size_t topic;
    double time_s;
    std::string bytes;
  };
  std::vector<Topic> topics;
  std::vector<Message> messages;
};

enum class Packing { outside_chunks, none, lz4, zstd, bz2 };

inline std::string packed(const std::string& bytes, Packing packing) {
  std::string out;
  std::size_t size = bytes.size();
  if (packing == Packing::lz4) {
    out.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
    size = LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
  } else if (packing == Packing::zstd) {
    out.resize(ZSTD_compressBound(bytes.size()));
    size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3);
  } else if (packing == Packing::bz2) {
    out.resize(bytes.size() * 2 + 600);
    auto written = static_cast<unsigned int>(out.size());
    std::string in = bytes;
    BZ2_bzBuffToBuffCompress(out.data(), &written, in.data(), static_cast<unsigned int>(in.size()), 9, 0, 0);
    size = written;
  } else {
    out = bytes;
  }
  out.resize(size);
  return out;
}

/// An MCAP without an index, of one chunk or none.
inline std::string mcap_bytes(const BagContent& bag, Packing packing, bool ros1 = false) {
  const auto string = [](const std::string& text) {
    return ByteWriter().add(static_cast<std::uint32_t>(text.size())).text(text).bytes();
  };
  const auto record = [](std::uint8_t opcode, const std::string& body) {
    return ByteWriter().add(opcode).add(static_cast<std::uint64_t>(body.size())).text(body).bytes();
  };
  std::string records;
  for (std::size_t i = 0; i < bag.topics.size(); ++i) {
    std::string type = bag.topics[i].type;
    if (!ros1) type.insert(type.find('/'), "/msg");
    const auto id = static_cast<std::uint16_t>(i + 1);
    records += record(0x03, ByteWriter().add(id).text(string(type) + string("ros2msg") + string("")).bytes());
    records += record(0x04, ByteWriter()
                                .add(id)
                                .add(id)
                                .text(string(bag.topics[i].name) + string(ros1 ? "ros1" : "cdr") + string(""))
                                .bytes());
  }
  for (const BagContent::Message& message : bag.messages) {
    const auto time = static_cast<std::uint64_t>(std::llround(message.time_s * 1e9));
    records += record(0x05, ByteWriter()
                                .add(static_cast<std::uint16_t>(message.topic + 1))
                                .add<std::uint32_t>(0)
                                .add(time)
                                .add(time)
                                .text(message.bytes)
                                .bytes());
  }
  if (packing != Packing::outside_chunks) {
    const std::string body = packed(records, packing);
    const std::string name = packing == Packing::lz4 ? "lz4" : packing == Packing::zstd ? "zstd" : "";
    const auto checksum =
        crc32_z(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<z_size_t>(records.size()));
    records = record(0x06, ByteWriter()
                               .add<std::uint64_t>(0)
                               .add<std::uint64_t>(0)
                               .add(static_cast<std::uint64_t>(records.size()))
                               .add(static_cast<std::uint32_t>(checksum))
                               .text(string(name))
                               .add(static_cast<std::uint64_t>(body.size()))
                               .text(body)
                               .bytes());
  }
  const std::string magic("\x89MCAP0\r\n", 8);
  return magic + record(0x01, string("ros2") + string("test")) + record(0x09, "attachment") + records +
         record(0x0f, std::string(4, '\0')) + record(0x02, std::string(20, '\0')) + magic;
}

/// A bag of ROS 1 without an index, of one chunk or none.
inline std::string ros1_bag_bytes(const BagContent& bag, Packing packing) {
  const auto sized = [](const std::string& text) {
    return ByteWriter().add(static_cast<std::uint32_t>(text.size())).text(text).bytes();
  };
  const auto field = [&](const std::string& name, const std::string& value) {
    return sized(name + "=" + value);
  };
  const auto number = [](auto value) { return ByteWriter().add(value).bytes(); };
  const auto record = [&](const std::string& header, const std::string& data) {
    return sized(header) + sized(data);
  };
  std::string records;
  for (std::size_t i = 0; i < bag.topics.size(); ++i) {
    records += record(field("op", "\x07") + field("conn", number(static_cast<std::uint32_t>(i))) +
                          field("topic", bag.topics[i].name),
                      field("topic", bag.topics[i].name) + field("type", bag.topics[i].type));
  }
  for (const BagContent::Message& message : bag.messages) {
    const auto seconds = static_cast<std::uint32_t>(message.time_s);
    const auto nanoseconds = static_cast<std::uint32_t>(std::lround((message.time_s - seconds) * 1e9));
    records += record(field("op", "\x02") + field("conn", number(static_cast<std::uint32_t>(message.topic))) +
                          field("time", number(seconds) + number(nanoseconds)),
                      message.bytes);
  }
  const std::string start =
      "#ROSBAG V2.0\n" + record(field("op", "\x03") + field("index_pos", number(std::uint64_t{0})), "    ");
  if (packing == Packing::outside_chunks) return start + records;
  const std::string name = packing == Packing::lz4 ? "lz4" : packing == Packing::bz2 ? "bz2" : "none";
  return start + record(field("op", "\x05") + field("compression", name) +
                            field("size", number(static_cast<std::uint32_t>(records.size()))),
                        packed(records, packing));
}

/// A bag of ROS 2 in SQLite.
inline void write_ros2_sqlite(const std::filesystem::path& file, const BagContent& bag) {
  sqlite3* database = nullptr;
  if (sqlite3_open(file.c_str(), &database) != SQLITE_OK) throw std::runtime_error("cannot be opened");
  sqlite3_exec(
      database,
      "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; BEGIN;"
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);",
      nullptr, nullptr, nullptr);
  sqlite3_stmt* row = nullptr;
  sqlite3_prepare_v2(database, "INSERT INTO topics VALUES (?, ?, ?, 'cdr')", -1, &row, nullptr);
  for (std::size_t i = 0; i < bag.topics.size(); ++i) {
    std::string type = bag.topics[i].type;
    type.insert(type.find('/'), "/msg");
    sqlite3_bind_int64(row, 1, static_cast<std::int64_t>(i + 1));
    sqlite3_bind_text(row, 2, bag.topics[i].name.c_str(), -1, SQLITE_TRANSIENT);
    sqlite3_bind_text(row, 3, type.c_str(), -1, SQLITE_TRANSIENT);
    sqlite3_step(row);
    sqlite3_reset(row);
  }
  sqlite3_finalize(row);
  sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", -1, &row,
                     nullptr);
  for (const BagContent::Message& message : bag.messages) {
    sqlite3_bind_int64(row, 1, static_cast<std::int64_t>(message.topic + 1));
    sqlite3_bind_int64(row, 2, std::llround(message.time_s * 1e9));
    sqlite3_bind_blob(row, 3, message.bytes.data(), static_cast<int>(message.bytes.size()), SQLITE_TRANSIENT);
    sqlite3_step(row);
    sqlite3_reset(row);
  }
  sqlite3_finalize(row);
  sqlite3_exec(database, "COMMIT", nullptr, nullptr, nullptr);
  sqlite3_close(database);
}

}  // namespace credence::internal::testing

#pragma once

#include <filesystem>
#include <string_view>

namespace credence::internal {

inline constexpr std::string_view kDiskIsFull =
    "the disk is full: free some space and run the same command again, which goes on from what is stored";

/// SQLite maps the index of its log (results.sqlite-shm) into memory, but asks the disk for one byte of each
/// of its pages only: on a full disk of smaller blocks a write to it would end the process (SIGBUS). So room
/// is asked for before the file is made, and all of it is taken as soon as it is there, or StoreError thrown
/// that the disk is full; systems that do not say how much room they have are taken to have enough.
bool has_room(const std::filesystem::path& database);
void require_room(const std::filesystem::path& database);
void reserve_shared_memory(const std::filesystem::path& database);

/// Throws StoreError where something else than a file has this name: of a pipe, whoever opens it may wait for
/// ever.
void require_regular_file(const std::filesystem::path& file);

}  // namespace credence::internal

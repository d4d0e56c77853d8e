#pragma once

#include <filesystem>
#include <string>

#include "ccvt/export.h"

namespace ccvt::io {

class LiveFile;

/// A new, empty file beside the one that it is to become, under a random name that no other file
/// has, `.ccvt-*.part`. Links are followed as output_target() says. It has the permissions of the
/// file that it is to replace, else those that the umask leaves. Unless published it is removed by
/// the destructor, and by remove_unfinished_files().
class CCVT_EXPORT UnfinishedFile {
 public:
  /// Throws IoError when `target` is there and no regular file, or may not be written, or the file
  /// cannot be made.
  explicit UnfinishedFile(std::filesystem::path target);
  UnfinishedFile(UnfinishedFile&& other) noexcept;
  UnfinishedFile& operator=(UnfinishedFile&&) = delete;
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;
  ~UnfinishedFile();

  /// As it was given.
  [[nodiscard]] const std::filesystem::path& target() const { return target_; }
  /// Where the file is until it is published.
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// The file, open for reading and writing, until it is taken.
  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// The same, for the caller to close; to be called once.
  [[nodiscard]] int take_descriptor();
  /// Renames, no more: who publishes several has no pause between them. Throws IoError.
  void publish();
  /// So that the name of a published file outlasts a power failure, where the file system knows of
  /// this.
  void keep_name() const;
  [[nodiscard]] std::filesystem::path directory() const { return final_.parent_path(); }

  /// Throws IoError: target cannot be written, for the reason that errno gives.
  [[noreturn]] void fail(int error) const;

 private:
  /// The permissions of the target, or -1 when there is none. Throws IoError.
  [[nodiscard]] int check_target() const;
  void create(const std::filesystem::path& directory, int permissions);
  void drop() noexcept;

  std::filesystem::path target_;
  std::filesystem::path final_;
  std::filesystem::path path_;
  LiveFile* live_ = nullptr;
  int descriptor_ = -1;
};

}  // namespace ccvt::io

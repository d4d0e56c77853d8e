#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "ccvt/export.h"

namespace ccvt {

/// A scope in which files are written, but appear under their names together, at its end:
///
///   ccvt::Publication together;
///   ccvt::write_owners("owners.npy", owners);
///   ccvt::write_points("sites.npy", sites);
///   together.publish();
///
/// It holds for all writers of the library that are called in its thread while it lives, and is to
/// be destroyed in that thread, which is why it is a local variable only. Scopes may be nested:
/// then the outermost publishes all.
class CCVT_EXPORT Publication {
 public:
  Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;
  static void* operator new(std::size_t) = delete;
  /// Removes what has not been published.
  ~Publication();

  /// Renames the files, in the order in which they were written, one right after the other. All are
  /// complete by then, so that a process that is killed leaves some new beside some old ones only
  /// when that happens between two renames. Throws IoError, which names those that appeared and
  /// those that did not, when the system refuses one; the rest is removed. Within another scope:
  /// hands the files to that.
  void publish();

  /// Where a file that has been written to `target` is until then. Throws InvalidInput when there
  /// is none.
  [[nodiscard]] std::filesystem::path unpublished(const std::filesystem::path& target) const;

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Unlinks what this process has begun to write and not yet published. May be called in a signal
/// handler, before _exit(); a writer that goes on after it throws IoError.
CCVT_EXPORT void remove_unfinished_files() noexcept;

}  // namespace ccvt

#include "io/publication.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/publication.h"

namespace ccvt {

struct Publication::Implementation {
  std::vector<io::UnfinishedFile> files;
  Implementation* outer = nullptr;
};

namespace {

// A scope and not an argument of all writers: so it holds for writers that call writers, too.
thread_local Publication::Implementation* innermost = nullptr;

/// ", "-separated names of files[first..last).
std::string names(const std::vector<io::UnfinishedFile>& files, std::size_t first,
                  std::size_t last) {
  std::string text;
  for (std::size_t i = first; i < last; ++i) {
    text += (i > first ? ", " : "") + files[i].target().string();
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace

Publication::Publication() : implementation_(std::make_unique<Implementation>()) {
  implementation_->outer = std::exchange(innermost, implementation_.get());
}

Publication::~Publication() { innermost = implementation_->outer; }

void Publication::publish() {
  std::vector<io::UnfinishedFile> files = std::move(implementation_->files);
  implementation_->files.clear();
  if (implementation_->outer != nullptr) {
    for (io::UnfinishedFile& file : files) implementation_->outer->files.push_back(std::move(file));
    return;
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    try {
      files[i].publish();
    } catch (const IoError& error) {
      if (files.size() == 1) throw;
      throw IoError(error.what() + ("; written before it: " + names(files, 0, i)) +
                    "; not written either: " + names(files, i + 1, files.size()));
    }
  }
  // After all renames: a disk takes milliseconds for it, in which a killed process would leave some
  // outputs old and some new.
  std::set<std::filesystem::path> kept;
  for (const io::UnfinishedFile& file : files) {
    if (kept.insert(file.directory()).second) file.keep_name();
  }
}

std::filesystem::path Publication::unpublished(const std::filesystem::path& target) const {
  const auto& files = implementation_->files;
  const auto file = std::find_if(files.rbegin(), files.rend(),
                                 [&](const auto& each) { return each.target() == target; });
  if (file != files.rend()) return file->path();
  throw InvalidInput(target.string() + ": is not among the files to be published");
}

namespace io {

void publish(UnfinishedFile file) {
  if (innermost == nullptr) {
    file.publish();
    file.keep_name();
  } else {
    innermost->files.push_back(std::move(file));
  }
}

}  // namespace io
}  // namespace ccvt

#include "cli/kept_run.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <system_error>
#include <thread>

#include "checkpoint/checkpoint_file.h"
#include "cli/run.h"

namespace ccvt::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* kName = "ccvt.checkpoint";
constexpr std::chrono::milliseconds kBetweenTries{50};

[[noreturn]] void refuse(const fs::path& directory, const std::string& reason) {
  throw InvalidInput("--checkpoint: " + directory.string() + ": " + reason);
}

/// Whether it is a checkpoint as far as it has been written, perhaps not at all.
bool begins_as_checkpoint(const fs::path& file) {
  std::array<char, kCheckpointMagic.size()> begin{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(begin.data(), begin.size());
  return std::equal(begin.begin(), begin.begin() + stream.gcount(), kCheckpointMagic.begin());
}

}  // namespace

fs::path checkpoint_file(const CommonArguments& arguments) {
  return arguments.checkpoint.empty() ? fs::path() : arguments.checkpoint / kName;
}

KeptRun::KeptRun(const CommonArguments& arguments, bool holds, std::chrono::milliseconds patience)
    : directory_(arguments.checkpoint),
      seconds_(arguments.checkpoint_every),
      quiet_(arguments.quiet) {
  if (directory_.empty()) return;
  file_ = checkpoint_file(arguments);
  if (!holds) return;
  std::error_code error;
  fs::create_directory(directory_, error);
  if (error) refuse(directory_, "cannot be made: " + error.message());
  hold(patience);
}

KeptRun::~KeptRun() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

/// The lock goes when the process does, however that ends. Some file systems have none.
void KeptRun::hold(std::chrono::milliseconds patience) {
  descriptor_ = ::open(directory_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0 || ::access(directory_.c_str(), W_OK) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    refuse(directory_, std::generic_category().message(error));
  }
  const auto until = std::chrono::steady_clock::now() + patience;
  while (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return;
    if (std::chrono::steady_clock::now() >= until) {
      ::close(descriptor_);
      refuse(directory_, "another process keeps its run there");
    }
    std::this_thread::sleep_for(kBetweenTries);
  }
  remove_left_over();
}

void KeptRun::remove_left_over() const {
  std::error_code error;
  for (fs::directory_iterator entry(directory_, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& file = entry->path();
    const bool unfinished =
        file.filename().string().rfind(".ccvt-", 0) == 0 && file.extension() == ".part";
    std::error_code ignored;
    if (unfinished && begins_as_checkpoint(file)) fs::remove(file, ignored);
  }
}

Options KeptRun::options(Options options, Progress& progress) const {
  options.checkpoint = file_;
  options.checkpoint_seconds = seconds_;
  options.on_checkpoint = [this, &progress](const CheckpointRecord& record) {
    tell(record, progress);
  };
  return options;
}

void KeptRun::tell(const CheckpointRecord& record, Progress& progress) const {
  if (quiet_ || record.event == CheckpointRecord::Event::saved) return;
  progress.clear();
  if (record.event == CheckpointRecord::Event::continued) {
    cli::tell("goes on from " + directory_.string() + ", after iteration " +
              std::to_string(record.iteration));
  } else {
    cli::tell("warning: " + record.failure +
              ": the run goes on, and what was kept of it before stays");
  }
}

void KeptRun::end(const Summary& summary) const {
  if (!keeps()) return;
  const Termination how = summary.termination;
  std::error_code ignored;
  if (how == Termination::stable || how == Termination::blue_noise ||
      how == Termination::energy_tolerance) {
    fs::remove(file_, ignored);
  } else if (!quiet_) {
    const std::string there = directory_.string();
    cli::tell(fs::exists(file_, ignored)
                  ? "the same command, or one with other limits, goes on from " + there
                  : there + ": nothing is kept there: the same command begins anew");
  }
}

}  // namespace ccvt::cli

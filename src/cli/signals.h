#pragma once

#include <signal.h>  // NOLINT(modernize-deprecated-headers): <csignal> lacks POSIX's sigset_t

#include <cstddef>
#include <filesystem>
#include <functional>

namespace ccvt::cli {

/// From now on Ctrl-C (SIGINT) ends the program at once, with status 130, until it is watched; so
/// do SIGTERM, SIGHUP, SIGQUIT and SIGXCPU at any time, with 128 and their number. Unfinished
/// outputs are removed. Those three last, where they are ignored, stay so; SIGINT is handled even
/// where it was ignored, as shells have it for the background jobs of scripts. Writes beyond a
/// limit of size, and to a pipe that nobody reads, fail instead of ending the program.
void handle_signals();

/// From now on the program says so and ends with status 1 when this file, which is mapped, turns
/// out to be shorter than it was; without it SIGBUS would end it without a word. Unfinished outputs
/// are removed.
void tell_if_cut_short(const std::filesystem::path& file);

/// To be handed to the library as `cancelled`, right before the call that asks it and has something
/// to return then: from now on the first Ctrl-C makes it true, and the second one ends the program.
std::function<bool()> watch_interrupts();

/// Whether there was a Ctrl-C since they are watched.
[[nodiscard]] bool interrupted();

/// As if there had been one: it came to another process of the same run.
void interrupt_too();

/// While one lives, signals that would end the program wait for its end.
class EndsHeldBack {
 public:
  EndsHeldBack();
  EndsHeldBack(const EndsHeldBack&) = delete;
  EndsHeldBack& operator=(const EndsHeldBack&) = delete;
  ~EndsHeldBack();
};

/// While one lives, the first signal that would end the program, SIGTERM and its like, is as the
/// first Ctrl-C: for those to whom a launcher passes Ctrl-C on as SIGTERM.
class EndsAsked {
 public:
  EndsAsked();
  EndsAsked(const EndsAsked&) = delete;
  EndsAsked& operator=(const EndsAsked&) = delete;
  ~EndsAsked();

  /// The signal that has come; 0: none.
  [[nodiscard]] static int signal();
};

/// While one lives, no signal comes to its thread. For a moment, before there are other threads.
class SignalsBlocked {
 public:
  SignalsBlocked();
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;
  ~SignalsBlocked();

 private:
  sigset_t before_;
};

/// Two files that a signal which ends the program removes; "": none any more.
void unlink_at_end(std::size_t slot, const std::filesystem::path& file);

/// A directory that a signal which ends the program removes, if it is empty; "": none any more.
void remove_at_end(const std::filesystem::path& directory);

}  // namespace ccvt::cli

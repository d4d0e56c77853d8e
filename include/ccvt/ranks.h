#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/export.h"

namespace ccvt {

/// The processes, "ranks", that work on one problem together, as one of them sees them. The library
/// has none of its own: ccvt/mpi.h makes them of an MPI communicator.
///
/// All ranks make the same calls in the same order. A Problem that is given ranks needs nothing
/// else: see Problem::Problem(). What goes wrong on one rank only, such as memory running out,
/// leaves the others waiting: whoever catches it must end them, as MPI_Abort() does. Bad input on
/// one rank is InvalidInput on all of them, as are options, capacities and codewords that are not
/// the same on all but for threads, time limits and what is called; and a file that one cannot
/// read or write is IoError.
class CCVT_EXPORT Ranks {
 public:
  using Bytes = std::vector<std::byte>;

  Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  virtual ~Ranks();

  /// In 0..count() - 1.
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int count() const = 0;

  /// What each rank hands in, by rank; the same on all.
  [[nodiscard]] virtual std::vector<Bytes> gather(std::span<const std::byte> own) = 0;
  /// The same where all know how much each hands in, `sizes[r]` bytes of rank r, and have room for
  /// it: `all` has them one rank's after the other's, each its own before, and all afterwards.
  virtual void share(std::span<std::byte> all, std::span<const std::size_t> sizes);
  /// Sends `to[r]` to rank r, for all; what each has sent here, by rank. `to` has one for each.
  [[nodiscard]] virtual std::vector<Bytes> exchange(std::vector<Bytes> to) = 0;
  /// The same from where it lies to where it is wanted: `to[r]` goes to rank r, where it is as long
  /// as that one's room for it, and what r has sent here to `from[r]`. `to[rank()]` and
  /// `from[rank()]` are not looked at.
  virtual void exchange_parts(std::span<const std::span<const std::byte>> to,
                              std::span<const std::span<std::byte>> from);
  /// Sends a message to another rank without waiting for it.
  virtual void send(int to, Bytes message) = 0;
  /// The next message from another rank, in the order in which that sent them. Waits for it.
  [[nodiscard]] virtual Bytes receive(int from) = 0;
  /// Whether it is known that the next message from another rank is there, so that receive() does
  /// not wait: a rank then takes it between two pieces of its own work.
  [[nodiscard]] virtual bool has_come(int from);
};

/// What Ranks may be as well, where messages get on only while a function of theirs is called, as
/// long ones of MPI may: else whoever waits for one waits until its sender calls the next.
class CCVT_EXPORT MessageProgress {
 public:
  MessageProgress() = default;
  MessageProgress(const MessageProgress&) = delete;
  MessageProgress& operator=(const MessageProgress&) = delete;
  virtual ~MessageProgress();

  /// Lets what has been sent get on, and waits for nothing. Called after each piece of work by the
  /// thread that did it: on one that may not call the others it does nothing.
  virtual void progress() noexcept = 0;
};

}  // namespace ccvt

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "ccvt/mpi.h"

namespace ccvt {
namespace {

/// Of a message, and of what comes together: more is taken for a mistake, before memory is.
constexpr std::uint64_t kMost = std::uint64_t{1} << 38;
// MPI counts in int: what has more bytes goes in pieces.
constexpr std::size_t kPiece = std::size_t{1} << 30;

void require_possible(const std::vector<std::uint64_t>& sizes) {
  std::uint64_t all = 0;
  for (const std::uint64_t size : sizes) {
    if (size > kMost) throw std::length_error("ranks: a message has more than 256 GB");
    all += size;
  }
  if (all > kMost) throw std::length_error("ranks: messages have more than 256 GB together");
}

std::size_t pieces_of(const std::vector<std::uint64_t>& sizes) {
  std::size_t pieces = 0;
  for (const std::uint64_t size : sizes) pieces += (size + kPiece - 1) / kPiece;
  return pieces;
}

/// Messages between this rank and others, in pieces, all at the same time.
class Pieces {
 public:
  /// For so many pieces at the most.
  Pieces(MPI_Comm communicator, std::size_t most) : communicator_(communicator) {
    requests_.reserve(most);
  }

  /// The bytes are there until wait() has returned.
  void send(std::span<const std::byte> message, int to) {
    for_pieces(message, [&](const std::byte* piece, int size, MPI_Request* request) {
      MPI_Isend(piece, size, MPI_BYTE, to, kTag, communicator_, request);
    });
  }
  void receive(std::span<std::byte> message, int from) {
    for_pieces(message, [&](std::byte* piece, int size, MPI_Request* request) {
      MPI_Irecv(piece, size, MPI_BYTE, from, kTag, communicator_, request);
    });
  }
  void wait() {
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    requests_.clear();
  }

 private:
  static constexpr int kTag = 1;  ///< that of send() and receive() of ranks is 0

  template <class Byte, class Start>
  void for_pieces(std::span<Byte> message, const Start& start) {
    for (; !message.empty(); message = message.subspan(std::min(kPiece, message.size()))) {
      requests_.emplace_back();
      start(message.data(), static_cast<int>(std::min(kPiece, message.size())), &requests_.back());
    }
  }

  MPI_Comm communicator_;
  std::vector<MPI_Request> requests_;
};

/// How many bytes of messages of these sizes come from a place on, of each `most` at the most.
std::vector<int> counts_from(std::uint64_t begin, const std::vector<std::uint64_t>& sizes,
                             std::uint64_t most) {
  std::vector<int> counts;
  for (const std::uint64_t size : sizes) {
    counts.push_back(static_cast<int>(std::min(size - std::min(size, begin), most)));
  }
  return counts;
}

std::vector<int> places_of(const std::vector<int>& counts) {
  std::vector<int> places(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), 0);
  return places;
}

/// A message of so many bytes, or the size of a longer one.
constexpr std::size_t kShort = 56;
struct Short {
  std::uint64_t size;
  std::array<std::byte, kShort> bytes;
};

/// Calls `work`, of which what fails fails on this rank alone.
template <class Work>
auto on_this_rank(const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw MpiFailure{"out of memory for a message"};
  } catch (const std::exception& error) {
    throw MpiFailure{error.what()};
  }
}

/// Adds the time that it lives.
class Watch {
 public:
  explicit Watch(double& seconds) : seconds_(seconds), begin_(MPI_Wtime()) {}
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  ~Watch() { seconds_ += MPI_Wtime() - begin_; }

 private:
  double& seconds_;
  double begin_;
};

}  // namespace

MpiRanks::MpiRanks(MPI_Comm communicator) {
  MPI_Comm_dup(communicator, &communicator_);
  MPI_Comm_set_errhandler(communicator_, MPI_ERRORS_ARE_FATAL);
  MPI_Comm_rank(communicator_, &rank_);
  MPI_Comm_size(communicator_, &count_);
}

MpiRanks::~MpiRanks() {
  if (std::uncaught_exceptions() > 0) {
    // MPI may still read what is on its way.
    static_cast<void>(new (std::nothrow) std::list<Sent>(std::move(sent_)));
    return;
  }
  for (Sent& message : sent_) {
    MPI_Waitall(static_cast<int>(message.requests.size()), message.requests.data(),
                MPI_STATUSES_IGNORE);
  }
  MPI_Comm_free(&communicator_);
}

std::vector<Ranks::Bytes> MpiRanks::gather(std::span<const std::byte> own) {
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    const auto ranks = static_cast<std::size_t>(count_);
    ++traffic_.messages;
    traffic_.gathered_bytes += static_cast<std::int64_t>(own.size());
    // Most messages are short: they come along with their sizes.
    Short mine{own.size(), {}};
    if (!own.empty() && own.size() <= kShort) {
      std::memcpy(mine.bytes.data(), own.data(), own.size());
    }
    std::vector<Short> heads(ranks);
    MPI_Allgather(&mine, sizeof(Short), MPI_BYTE, heads.data(), sizeof(Short), MPI_BYTE,
                  communicator_);
    if (std::all_of(heads.begin(), heads.end(), [](const Short& s) { return s.size <= kShort; })) {
      std::vector<Bytes> messages;
      for (const Short& head : heads) {
        messages.emplace_back(head.bytes.begin(),
                              head.bytes.begin() + static_cast<std::ptrdiff_t>(head.size));
      }
      return messages;
    }
    std::vector<std::uint64_t> sizes;
    for (const Short& head : heads) sizes.push_back(head.size);
    require_possible(sizes);
    std::vector<Bytes> messages(sizes.begin(), sizes.end());
    const std::uint64_t longest = *std::max_element(sizes.begin(), sizes.end());
    const auto senders =
        std::count_if(sizes.begin(), sizes.end(), [](auto size) { return size > 0; });
    const std::uint64_t most = kPiece / static_cast<std::uint64_t>(senders);  // of each at once
    std::vector<std::byte> all;
    for (std::uint64_t begin = 0; begin < longest; begin += most) {
      const std::vector<int> counts = counts_from(begin, sizes, most);
      const std::vector<int> places = places_of(counts);
      all.resize(static_cast<std::size_t>(places.back()) + static_cast<std::size_t>(counts.back()));
      const std::span<const std::byte> rest = own.subspan(std::min<std::size_t>(begin, own.size()));
      MPI_Allgatherv(rest.data(), counts[static_cast<std::size_t>(rank_)], MPI_BYTE, all.data(),
                     counts.data(), places.data(), MPI_BYTE, communicator_);
      for (std::size_t r = 0; r < ranks; ++r) {
        if (counts[r] == 0) continue;
        std::memcpy(messages[r].data() + begin, all.data() + places[r],
                    static_cast<std::size_t>(counts[r]));
      }
    }
    return messages;
  });
}

void MpiRanks::share(std::span<std::byte> all, std::span<const std::size_t> sizes) {
  if (all.size() > kPiece) return Ranks::share(all, sizes);
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    ++traffic_.messages;
    traffic_.gathered_bytes += static_cast<std::int64_t>(sizes[static_cast<std::size_t>(rank_)]);
    const std::vector<int> counts(sizes.begin(), sizes.end());
    const std::vector<int> places = places_of(counts);
    MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all.data(), counts.data(), places.data(),
                   MPI_BYTE, communicator_);
  });
}

std::vector<Ranks::Bytes> MpiRanks::exchange(std::vector<Bytes> to) {
  return on_this_rank([&] {
    const auto ranks = static_cast<std::size_t>(count_);
    const auto own = static_cast<std::size_t>(rank_);
    std::vector<std::uint64_t> sizes_out;
    for (const Bytes& message : to) sizes_out.push_back(message.size());
    std::vector<std::uint64_t> sizes(ranks);
    {
      const Watch watch(traffic_.seconds);
      MPI_Alltoall(sizes_out.data(), 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, communicator_);
    }
    require_possible(sizes_out);
    require_possible(sizes);
    std::vector<Bytes> from(ranks);
    for (std::size_t r = 0; r < ranks; ++r) from[r].resize(r == own ? 0 : sizes[r]);
    exchange_parts(std::vector<std::span<const std::byte>>(to.begin(), to.end()),
                   std::vector<std::span<std::byte>>(from.begin(), from.end()));
    from[own] = std::move(to[own]);
    return from;
  });
}

void MpiRanks::exchange_parts(std::span<const std::span<const std::byte>> to,
                              std::span<const std::span<std::byte>> from) {
  on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    const auto ranks = static_cast<std::size_t>(count_);
    const auto own = static_cast<std::size_t>(rank_);
    std::vector<std::uint64_t> sizes;
    for (const auto& part : to) sizes.push_back(part.size());
    for (const auto& part : from) sizes.push_back(part.size());
    // All memory is there before a message is on its way: MPI must not write to what is gone.
    Pieces pieces(communicator_, pieces_of(sizes));
    for (std::size_t k = 1; k < ranks; ++k) {
      const std::size_t r = (own + ranks - k) % ranks;
      pieces.receive(from[r], static_cast<int>(r));
    }
    for (std::size_t k = 1; k < ranks; ++k) {
      const std::size_t r = (own + k) % ranks;
      pieces.send(to[r], static_cast<int>(r));
      traffic_.messages += to[r].empty() ? 0 : 1;
      traffic_.sent_bytes += static_cast<std::int64_t>(to[r].size());
    }
    pieces.wait();
  });
}

void MpiRanks::send(int to, Bytes message) {
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    forget_delivered();
    ++traffic_.messages;
    traffic_.sent_bytes += static_cast<std::int64_t>(message.size());
    sender_ = std::this_thread::get_id();
    Sent& sent = sent_.emplace_back();
    sent.message = std::move(message);
    // Pieces follow until one is not whole, which may be empty.
    const std::size_t pieces = sent.message.size() / kPiece + 1;
    sent.requests.reserve(pieces);  // and all of its memory is there
    for (std::size_t k = 0; k < pieces; ++k) {
      const std::size_t size = std::min(kPiece, sent.message.size() - k * kPiece);
      sent.requests.emplace_back();
      MPI_Isend(sent.message.data() + k * kPiece, static_cast<int>(size), MPI_BYTE, to, 0,
                communicator_, &sent.requests.back());
    }
  });
}

Ranks::Bytes MpiRanks::receive(int from) {
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    Bytes bytes;
    for (bool whole = true; whole;) {
      MPI_Message message;
      MPI_Status status;
      MPI_Mprobe(from, 0, communicator_, &message, &status);
      int count = 0;
      MPI_Get_count(&status, MPI_BYTE, &count);
      const std::size_t before = bytes.size();
      bytes.resize(before + static_cast<std::size_t>(count));
      MPI_Mrecv(bytes.data() + before, count, MPI_BYTE, &message, MPI_STATUS_IGNORE);
      whole = static_cast<std::size_t>(count) == kPiece;
    }
    return bytes;
  });
}

bool MpiRanks::has_come(int from) {
  int come = 0;
  MPI_Iprobe(from, 0, communicator_, &come, MPI_STATUS_IGNORE);
  return come != 0;
}

void MpiRanks::progress() noexcept {
  if (std::this_thread::get_id() == sender_ && !sent_.empty()) forget_delivered();
}

void MpiRanks::forget_delivered() {
  for (auto message = sent_.begin(); message != sent_.end();) {
    int delivered = 0;
    MPI_Testall(static_cast<int>(message->requests.size()), message->requests.data(), &delivered,
                MPI_STATUSES_IGNORE);
    message = delivered != 0 ? sent_.erase(message) : std::next(message);
  }
}

}  // namespace ccvt

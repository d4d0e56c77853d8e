#include <algorithm>
#include <array>
#include <climits>
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

// MPI counts in int: in words a message may have 16 GB.
using Word = std::uint64_t;

int words_for(std::size_t bytes) {
  const std::size_t words = (bytes + sizeof(Word) - 1) / sizeof(Word);
  if (words > INT_MAX) throw std::length_error("ranks: a message has more than 16 GB");
  return static_cast<int>(words);
}

int total_of(const std::vector<int>& counts) {
  const std::int64_t all = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  if (all > INT_MAX) throw std::length_error("ranks: messages have more than 16 GB together");
  return static_cast<int>(all);
}

std::vector<int> places_of(const std::vector<int>& counts) {
  std::vector<int> places(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), places.begin(), 0);
  return places;
}

/// The messages that lie one after the other in `words`, from whole words on.
std::vector<Ranks::Bytes> unpack(const std::vector<Word>& words,
                                 const std::vector<std::uint64_t>& sizes,
                                 const std::vector<int>& places) {
  std::vector<Ranks::Bytes> messages;
  for (std::size_t r = 0; r < sizes.size(); ++r) {
    Ranks::Bytes& bytes = messages.emplace_back(sizes[r]);
    if (!bytes.empty()) std::memcpy(bytes.data(), words.data() + places[r], bytes.size());
  }
  return messages;
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
  for (Sent& message : sent_) MPI_Wait(&message.request, MPI_STATUS_IGNORE);
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
    std::vector<int> counts;
    for (const Short& head : heads) {
      sizes.push_back(head.size);
      counts.push_back(words_for(head.size));
    }
    std::vector<Word> all(static_cast<std::size_t>(total_of(counts)));
    const std::vector<int> places = places_of(counts);
    std::vector<Word> words(static_cast<std::size_t>(words_for(own.size())));
    if (!own.empty()) std::memcpy(words.data(), own.data(), own.size());
    MPI_Allgatherv(words.data(), words_for(own.size()), MPI_UINT64_T, all.data(), counts.data(),
                   places.data(), MPI_UINT64_T, communicator_);
    return unpack(all, sizes, places);
  });
}

std::vector<Ranks::Bytes> MpiRanks::exchange(std::vector<Bytes> to) {
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    const auto ranks = static_cast<std::size_t>(count_);
    std::vector<std::uint64_t> sizes_out;
    std::vector<int> counts_out;
    for (const Bytes& message : to) {
      sizes_out.push_back(message.size());
      counts_out.push_back(words_for(message.size()));
    }
    std::vector<std::uint64_t> sizes(ranks);
    MPI_Alltoall(sizes_out.data(), 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, communicator_);
    std::vector<int> counts;
    for (const std::uint64_t bytes : sizes) counts.push_back(words_for(bytes));
    std::vector<Word> out(static_cast<std::size_t>(total_of(counts_out)));
    std::vector<Word> in(static_cast<std::size_t>(total_of(counts)));
    const std::vector<int> places_out = places_of(counts_out);
    const std::vector<int> places = places_of(counts);
    for (std::size_t r = 0; r < ranks; ++r) {
      if (!to[r].empty()) std::memcpy(out.data() + places_out[r], to[r].data(), to[r].size());
      if (std::cmp_equal(r, rank_)) continue;
      traffic_.messages += to[r].empty() ? 0 : 1;
      traffic_.sent_bytes += static_cast<std::int64_t>(to[r].size());
    }
    to.clear();
    MPI_Alltoallv(out.data(), counts_out.data(), places_out.data(), MPI_UINT64_T, in.data(),
                  counts.data(), places.data(), MPI_UINT64_T, communicator_);
    return unpack(in, sizes, places);
  });
}

void MpiRanks::send(int to, Bytes message) {
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    forget_delivered();
    if (message.size() > INT_MAX) throw std::length_error("ranks: a message has more than 2 GB");
    ++traffic_.messages;
    traffic_.sent_bytes += static_cast<std::int64_t>(message.size());
    Sent& sent = sent_.emplace_back();
    sent.message = std::move(message);
    MPI_Isend(sent.message.data(), static_cast<int>(sent.message.size()), MPI_BYTE, to, 0,
              communicator_, &sent.request);
  });
}

Ranks::Bytes MpiRanks::receive(int from) {
  return on_this_rank([&] {
    const Watch watch(traffic_.seconds);
    MPI_Message message;
    MPI_Status status;
    MPI_Mprobe(from, 0, communicator_, &message, &status);
    int count = 0;
    MPI_Get_count(&status, MPI_BYTE, &count);
    Bytes bytes(static_cast<std::size_t>(count));
    MPI_Mrecv(bytes.data(), count, MPI_BYTE, &message, MPI_STATUS_IGNORE);
    return bytes;
  });
}

void MpiRanks::forget_delivered() {
  for (auto message = sent_.begin(); message != sent_.end();) {
    int delivered = 0;
    MPI_Test(&message->request, &delivered, MPI_STATUS_IGNORE);
    message = delivered != 0 ? sent_.erase(message) : std::next(message);
  }
}

}  // namespace ccvt

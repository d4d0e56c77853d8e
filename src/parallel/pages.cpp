#include "parallel/pages.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace ccvt {
namespace {

constexpr std::size_t kCacheLine = 64;
constexpr std::size_t kLargePage = std::size_t{1} << 21;

}  // namespace

void* allocate_pages(std::size_t bytes) {
  const bool large = bytes >= kLargePage / 2;
  const std::size_t alignment = large ? kLargePage : kCacheLine;
  if (bytes > SIZE_MAX - alignment) throw std::bad_alloc();
  const std::size_t rounded = (std::max(bytes, std::size_t{1}) + alignment - 1) / alignment;
  void* const memory = std::aligned_alloc(alignment, rounded * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  // The last page, too, where half of it is used.
  if (large) prefer_large_pages(memory, bytes + kLargePage / 2);
  return memory;
}

void free_pages(void* memory) noexcept { std::free(memory); }

/// Linux refuses what is more than all of its memory, unless it is told that not all is meant.
Pages reserve_pages(std::size_t bytes) {
#ifdef __linux__
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return {memory, bytes};
#else
  return {allocate_pages(bytes), 0};
#endif
}

void free_reserved(Pages pages) noexcept {
  if (pages.mapped == 0) return free_pages(pages.memory);
#ifdef __linux__
  munmap(pages.memory, pages.mapped);
#endif
}

void prefer_large_pages([[maybe_unused]] void* memory,
                        [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef __linux__
  // A wish: what comes of it changes nothing but the time. Of whole large pages only.
  const std::size_t off = reinterpret_cast<std::uintptr_t>(memory) % kLargePage;
  const std::size_t skipped = (kLargePage - off) % kLargePage;
  if (bytes < skipped + kLargePage) return;
  const std::size_t whole = (bytes - skipped) / kLargePage * kLargePage;
  madvise(static_cast<std::byte*>(memory) + skipped, whole, MADV_HUGEPAGE);
#endif
}

}  // namespace ccvt

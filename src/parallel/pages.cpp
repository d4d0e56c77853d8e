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
  const std::size_t alignment = bytes < 2 * kLargePage ? kCacheLine : kLargePage;
  if (bytes > SIZE_MAX - alignment) throw std::bad_alloc();
  const std::size_t rounded = (std::max(bytes, std::size_t{1}) + alignment - 1) / alignment;
  void* const memory = std::aligned_alloc(alignment, rounded * alignment);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef __linux__
  // A wish: what comes of it changes nothing but the time.
  if (alignment == kLargePage) madvise(memory, rounded * alignment, MADV_HUGEPAGE);
#endif
  return memory;
}

void free_pages(void* memory) noexcept { std::free(memory); }

}  // namespace ccvt

#pragma once

#include <cstddef>

namespace ccvt {

/// Memory without a value. Much of it comes in pages as large as the system has: at 4 kB a page,
/// first touches take a tenth of a run. Throws std::bad_alloc.
void* allocate_pages(std::size_t bytes);
/// The same, in pages as small as the system has: for memory of which a part is never touched. Of
/// the part that will be, prefer_large_pages().
void* allocate_small_pages(std::size_t bytes);
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;
void free_pages(void* memory) noexcept;

}  // namespace ccvt

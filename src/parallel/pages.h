#pragma once

#include <cstddef>

namespace ccvt {

/// Memory without a value. Much of it comes in pages as large as the system has: at 4 kB a page,
/// first touches take a tenth of a run. Throws std::bad_alloc.
void* allocate_pages(std::size_t bytes);
void free_pages(void* memory) noexcept;

}  // namespace ccvt

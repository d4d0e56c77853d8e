#pragma once

#include <cstddef>

namespace ccvt {

/// Memory without a value. Much of it comes in pages as large as the system has: at 4 kB a page,
/// first touches take a tenth of a run. Throws std::bad_alloc.
void* allocate_pages(std::size_t bytes);
void free_pages(void* memory) noexcept;

/// Memory of which a part is never touched, in pages as small as the system has: of the part that
/// will be, prefer_large_pages(). On Linux it may be more than the machine has.
struct Pages {
  void* memory;
  std::size_t mapped;  ///< bytes that the system itself gave; 0: of allocate_pages()
};
Pages reserve_pages(std::size_t bytes);
void free_reserved(Pages pages) noexcept;

void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

}  // namespace ccvt

#pragma once

#include <cstddef>
#include <vector>

namespace ccvt {

/// Memory without a value. From 1 MB on it comes in pages as large as the system has: at 4 kB a
/// page, first touches take a tenth of a run, a quarter on a virtual machine. Throws
/// std::bad_alloc.
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

/// So many equal values for a caller, who gets no Buffer.
template <class T>
std::vector<T> vector_in_large_pages(std::size_t size, T value) {
  std::vector<T> values;
  values.reserve(size);
  prefer_large_pages(values.data(), size * sizeof(T));
  values.assign(size, value);
  return values;
}

}  // namespace ccvt

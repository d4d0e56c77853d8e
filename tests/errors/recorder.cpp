// Loaded before the C++ library (LD_PRELOAD): appends the text of every exception that is thrown to
// the file that CCVT_ERROR_RECORD names, a line each.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <string>
#include <typeinfo>

extern "C" [[noreturn]] void __cxa_throw(void* object, std::type_info* type,
                                         void (*destructor)(void*)) {
  using Throw = void (*)(void*, std::type_info*, void (*)(void*));
  static const auto go_on = reinterpret_cast<Throw>(::dlsym(RTLD_NEXT, "__cxa_throw"));
  const char* const path = std::getenv("CCVT_ERROR_RECORD");
  void* exception = object;
  if (path != nullptr && typeid(std::exception).__do_catch(type, &exception, 1)) {
    std::string line = static_cast<const std::exception*>(exception)->what();
    std::replace(line.begin(), line.end(), '\n', ' ');
    line += '\n';
    const int file = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    [[maybe_unused]] const auto written = ::write(file, line.data(), line.size());
    ::close(file);
  }
  go_on(object, type, destructor);
  __builtin_unreachable();
}

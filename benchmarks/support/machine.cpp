#include "support/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <Eigen/Core>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "ccvt/version.h"

// These come from CMake.
#ifndef CCVT_BENCH_FLAGS
#define CCVT_BENCH_FLAGS "unknown"
#endif
#ifndef CCVT_BENCH_COMMIT
#define CCVT_BENCH_COMMIT "unknown"
#endif
#ifndef CCVT_BENCH_VERSIONS
#define CCVT_BENCH_VERSIONS "unknown"
#endif

namespace ccvt::bench {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

std::string date() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace

Json machine() {
  utsname system{};
  ::uname(&system);
  Json json;
  json["date"] = date();
  json["system"] = std::string(system.sysname) + " " + system.release + " " + system.machine;
  json["processor"] = processor_name();
  json["processors"] = std::thread::hardware_concurrency();
  json["memory_bytes"] = static_cast<std::int64_t>(::sysconf(_SC_PHYS_PAGES)) *
                         static_cast<std::int64_t>(::sysconf(_SC_PAGESIZE));
#ifdef __clang__
  json["compiler"] = std::string("Clang ") + __clang_version__;
#else
  json["compiler"] = std::string("GCC ") + __VERSION__;
#endif
  json["flags"] = CCVT_BENCH_FLAGS;
  json["commit"] = CCVT_BENCH_COMMIT;
  json["ccvt"] = CCVT_VERSION;
  json["versions"] = CCVT_BENCH_VERSIONS;
  return json;
}

std::string machine_line(const Json& machine) {
  const auto text = [&](const char* key) { return machine.value(key, std::string("unknown")); };
  return std::to_string(machine.value("processors", 0)) + " processors, " + text("processor") +
         ", " + text("compiler") + ", " + text("flags") + ", ccvt " + text("ccvt") + ", commit " +
         text("commit") + ", " + text("date").substr(0, 10);
}

}  // namespace ccvt::bench

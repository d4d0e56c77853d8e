#pragma once

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace ccvt::cli {

inline void write_page(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

}  // namespace ccvt::cli

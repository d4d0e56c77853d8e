#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

/// The extensions of files: what readers and writers go by, what they say when they refuse one, and
/// what the program's help lists.
namespace ccvt::io {

using Extensions = std::span<const std::string_view>;

/// Read as points.
inline constexpr std::array<std::string_view, 8> kPointFiles = {
    ".npy", ".csv", ".txt", ".ply", ".fvecs", ".bvecs", ".gadget", ".hdf5"};
/// Written as particles.
inline constexpr std::array<std::string_view, 2> kParticleFiles = {".gadget", ".hdf5"};
/// Written as points or as particles.
inline constexpr std::array<std::string_view, 5> kSiteFiles = {".npy", ".csv", ".txt", ".gadget",
                                                               ".hdf5"};
/// Written as points; read and written as whole numbers.
inline constexpr std::array<std::string_view, 3> kTableFiles = {".npy", ".csv", ".txt"};
/// Written as points that were chosen from others.
inline constexpr std::array<std::string_view, 4> kThinFiles = {".ply", ".csv", ".txt", ".npy"};
/// Read as volumes.
inline constexpr std::array<std::string_view, 6> kVolumeFiles = {".nii",  ".nii.gz", ".nrrd",
                                                                 ".nhdr", ".npy",    ".raw"};
/// Read as meshes.
inline constexpr std::array<std::string_view, 2> kMeshFiles = {".ply", ".obj"};
/// Written as samples of a volume or a surface.
inline constexpr std::array<std::string_view, 6> kSampleFiles = {".ply", ".vtp", ".vtk",
                                                                 ".csv", ".txt", ".npy"};
/// Written as a stippled picture, or as the centres of its dots.
inline constexpr std::array<std::string_view, 5> kStippleFiles = {".svg", ".png", ".csv", ".txt",
                                                                  ".npy"};
inline constexpr std::array<std::string_view, 1> kPictureFiles = {".png"};

/// The text with a to z for A to Z, whatever the locale.
inline std::string in_lower_case(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return result;
}

/// The extension in lower case, with its dot.
inline std::string extension_of(const std::filesystem::path& path) {
  return in_lower_case(path.extension().string());
}

inline bool is_among(Extensions extensions, std::string_view extension) {
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

/// ".npy, .csv, .txt"; `last`, such as " or ", parts the last two.
template <class Names>
std::string list_of(const Names& names, std::string_view last = ", ") {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) list += i + 1 == names.size() ? last : ", ";
    list += names[i];
  }
  return list;
}

}  // namespace ccvt::io

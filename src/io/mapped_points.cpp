#include "ccvt/mapped_points.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "checks.h"
#include "io/finite.h"
#include "io/formats.h"
#include "io/input_file.h"
#include "io/mapped_file.h"
#include "io/npy_points.h"
#include "io/point_layout.h"
#include "io/vecs.h"

namespace ccvt {

namespace {

template <class Scalar>
std::optional<io::PointLayout> layout_of(const std::filesystem::path& path,
                                         const ReadOptions& options) {
  if (!options.columns.empty()) return {};
  std::optional<io::PointLayout> layout;
  if (io::is_vecs(path)) {
    layout = io::layout_of_vecs(path);
  } else if (io::extension_of(path) == ".npy") {
    layout = io::layout_of_npy(path);
  }
  constexpr auto kScalar = sizeof(Scalar) == 4 ? ScalarType::float32 : ScalarType::float64;
  if (layout && (layout->scalar != kScalar || layout->offset % sizeof(Scalar) != 0)) return {};
  return layout;
}

}  // namespace

template <class Scalar>
struct MappedPoints<Scalar>::Implementation {
  std::optional<io::MappedFile> file;
  Points<Scalar> read;
  PointsView<Scalar> view;

  void map(const std::filesystem::path& path, const io::PointLayout& layout,
           const io::RowRange& rows) {
    const io::InputFile checked(path);
    io::require_countable(checked, rows.size());
    file.emplace(path, checked.size());
    // What the layout is of may have been another file: one of another size is told.
    const auto last = static_cast<std::uint64_t>(layout.stride) * (layout.count - 1);
    const std::uint64_t scalars = last + static_cast<std::uint64_t>(layout.dimension);
    if (layout.offset + scalars * sizeof(Scalar) != checked.size()) {
      checked.fail("has changed while it was read");
    }
    const void* const first = file->data() + layout.offset;
    view = {
        static_cast<const Scalar*>(first) + static_cast<std::ptrdiff_t>(rows.begin) * layout.stride,
        layout.dimension, static_cast<Index>(rows.size()), layout.stride};
    if (io::is_vecs(path)) io::check_dimensions(checked, file->data(), layout, rows);
    io::check_finite(checked, view, rows.begin);
  }
};

template <class Scalar>
MappedPoints<Scalar>::MappedPoints(const std::filesystem::path& path, const ReadOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  if (const auto layout = layout_of<Scalar>(path, options)) {
    implementation_->map(path, *layout, io::RowRange(options, layout->count));
    return;
  }
  implementation_->read = read_points<Scalar>(path, options);
  implementation_->view = view_points(implementation_->read);
}

template <class Scalar>
MappedPoints<Scalar>::MappedPoints(MappedPoints&&) noexcept = default;
template <class Scalar>
MappedPoints<Scalar>& MappedPoints<Scalar>::operator=(MappedPoints&&) noexcept = default;
template <class Scalar>
MappedPoints<Scalar>::~MappedPoints() = default;

template <class Scalar>
PointsView<Scalar> MappedPoints<Scalar>::view() const {
  return whole("points", implementation_).view;
}

template <class Scalar>
bool MappedPoints<Scalar>::mapped() const {
  return whole("points", implementation_).file.has_value();
}

template <class Scalar>
void MappedPoints<Scalar>::check_unchanged() const {
  const auto& file = whole("points", implementation_).file;
  if (file) file->check_unchanged();
}

template <class Scalar>
bool MappedPoints<Scalar>::can_map(const std::filesystem::path& path, const ReadOptions& options) {
  return layout_of<Scalar>(path, options).has_value();
}

template class MappedPoints<float>;
template class MappedPoints<double>;

}  // namespace ccvt

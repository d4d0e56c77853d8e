#include "sampling/density_parts.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include "number_text.h"
#include "parallel/loops.h"
#include "parallel/together.h"
#include "sampling/grid_world.h"
#include "sampling/mass.h"

namespace ccvt {
namespace {

bool is_density(double value) { return value >= 0 && value <= std::numeric_limits<double>::max(); }

[[noreturn]] void refuse_density(const DensityGrid& grid, const CellDensities& densities,
                                 std::int64_t cell) {
  std::vector<std::int64_t> position(grid.shape.size());
  cell_position(cell, grid.shape, position);
  const std::string mapped =
      grid.map ? concat(", and its density ", densities(cell)) : std::string();
  throw InvalidInput(concat("grid: values[", cell, "], cell ", std::span(position),
                            " (fastest axis first), is ", densities.value(cell), mapped,
                            ", but must be finite and not negative"));
}

std::int64_t cells_of(std::span<const std::int64_t> shape) {
  return std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
}

/// The first cell, if any, whose density is refused.
struct Refused {
  static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t cell = none;

  void add(std::int64_t other) { cell = std::min(cell, other); }
  /// Adjacent cells.
  void add(std::int64_t first, std::span<const double> densities) {
    bool all = true;
    for (const double density : densities) all &= is_density(density);
    if (all) return;
    const auto bad = std::find_if_not(densities.begin(), densities.end(), is_density);
    add(first + (bad - densities.begin()));
  }
};

double sum(std::span<const double> row) { return std::accumulate(row.begin(), row.end(), 0.0); }

/// `plain`: values are densities as they are.
void require_total(const DensityGrid& grid, std::span<const double> masses, bool plain) {
  GroupedSum total;
  for (const double mass : masses) total.add(mass);
  if (total.value() == 0) {
    throw InvalidInput(
        concat("grid: all ", cells_of(grid.shape),
               plain ? " values are 0" : " densities are 0, as their map, or the mask, has it"));
  }
  if (!std::isfinite(total.value())) throw InvalidInput("grid: the sum of the values overflows");
}

}  // namespace

/// Parts of up to 4096 cells, and fewer where there would be less than a thousand parts.
int level_of_parts(std::span<const std::int64_t> shape) {
  const std::int64_t cells = cells_of(shape);
  const auto axes = std::count_if(shape.begin(), shape.end(), [](std::int64_t n) { return n > 1; });
  const std::int64_t most = std::clamp<std::int64_t>(cells / 1024, 1, 4096);
  int level = 0;
  while (axes > 0 && (level + 1) * axes < 62 && (std::int64_t{1} << ((level + 1) * axes)) <= most) {
    ++level;
  }
  return level == 0 && cells > 65'536 ? 1 : level;
}

GridLayers::GridLayers(std::span<const std::int64_t> shape, int level) {
  for (const std::int64_t n : shape) {
    if (n == 1) continue;
    cells *= count;
    count = n;
  }
  while (thickness < count && thickness < std::int64_t{1} << level) thickness *= 2;
}

LayerRange GridLayers::of(int rank, int ranks) const {
  const auto begin_of = [&](std::int64_t r) {
    return std::min(count, thick() * r / ranks * thickness);
  };
  return {begin_of(rank), begin_of(std::int64_t{rank} + 1)};
}

LayerRange GridLayers::around(int rank, int ranks) const {
  const LayerRange own = of(rank, ranks);
  if (own.begin == own.end) return own;
  return {std::max<std::int64_t>(own.begin - 1, 0), std::min(own.end + 1, count)};
}

int GridLayers::rank_of(std::int64_t layer, int ranks) const {
  return static_cast<int>(((layer / thickness + 1) * ranks - 1) / thick());
}

DensityParts::DensityParts(std::span<const std::int64_t> shape)
    : curve_(shape),
      level_(level_of_parts(shape)),
      layers_(shape, level_),
      parts_(curve_.parts(level_)),
      own_(parts_.size()) {
  std::iota(own_.begin(), own_.end(), std::size_t{0});
}

DensityParts::DensityParts(std::span<const std::int64_t> shape, const Ranks& ranks)
    : DensityParts(shape) {
  std::erase_if(own_,
                [&](std::size_t part) { return rank_of(part, ranks.count()) != ranks.rank(); });
}

std::vector<double> DensityParts::own_masses(const DensityGrid& grid,
                                             const CellDensities& densities,
                                             const Arena& arena) const {
  std::vector<double> masses(own_.size());
  std::vector<std::size_t> in_memory(own_.size());
  std::iota(in_memory.begin(), in_memory.end(), std::size_t{0});
  const auto part = [&](std::size_t k) -> const HilbertCurve::Part& { return parts_[own_[k]]; };
  std::sort(in_memory.begin(), in_memory.end(),
            [&](std::size_t a, std::size_t b) { return part(a).index < part(b).index; });
  PerWorker<Refused> refused(arena);
  PerWorker<std::vector<double>> rows(arena);
  // Of parts that lie side by side, whole rows: in those of single parts, memory would not be read
  // in its order (512^3 values: 2.4 s, not .65).
  const auto add_rows = [&](std::span<const std::size_t> run, int worker) {
    std::vector<double>& row = rows[worker];
    curve_.visit_rows(part(run.front()), std::ssize(run), level_,
                      [&](std::int64_t first, std::int64_t count, std::int64_t) {
                        row.resize(static_cast<std::size_t>(count));
                        densities.row(first, row);
                        refused[worker].add(first, row);
                        const std::size_t side = std::size_t{1} << curve_.limited(level_);
                        for (std::size_t p = 0; p < run.size(); ++p) {
                          const std::span<const double> rest = std::span(row).subspan(p * side);
                          masses[run[p]] += sum(rest.first(std::min(side, rest.size())));
                        }
                      });
  };
  arena.for_ranges(masses.size(), 64, [&](std::size_t begin, std::size_t end, int worker) {
    while (begin < end) {
      std::size_t next = begin + 1;
      while (next < end &&
             curve_.follows(part(in_memory[next]), part(in_memory[next - 1]), level_)) {
        ++next;
      }
      add_rows(std::span(in_memory).subspan(begin, next - begin), worker);
      begin = next;
    }
  });
  Refused first;
  for (int worker = 0; worker < arena.threads(); ++worker) first.add(refused[worker].cell);
  if (first.cell != Refused::none) refuse_density(grid, densities, first.cell);
  return masses;
}

/// Of each part, from the rank that has it.
std::vector<double> DensityParts::of_all(Ranks& ranks, std::span<const double> own) const {
  const std::vector<Ranks::Bytes> messages = ranks.gather(std::as_bytes(own));
  std::vector<ByteReader> masses(messages.begin(), messages.end());
  std::vector<double> all;
  all.reserve(parts_.size());
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    all.push_back(masses[static_cast<std::size_t>(rank_of(part, ranks.count()))].get<double>());
  }
  return all;
}

std::vector<double> DensityParts::masses(const DensityGrid& grid, const CellDensities& densities,
                                         const Arena& arena, Ranks* ranks) const {
  std::vector<double> masses;
  // The first cell that is refused is on the lowest of the ranks that refuse one.
  agree(ranks, [&] { masses = own_masses(grid, densities, arena); });
  if (ranks != nullptr) masses = of_all(*ranks, masses);
  require_total(grid, masses, !any(ranks, grid.map || !grid.mask.empty()));
  return masses;
}

}  // namespace ccvt

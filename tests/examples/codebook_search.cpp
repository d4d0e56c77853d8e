// A search in inverted lists of equal length: a balanced codebook puts vectors into 64 lists, and a
// query looks only at the lists whose codewords are nearest to it.
//   g++ -std=c++20 -O2 codebook_search.cpp $(pkg-config --cflags --libs ccvt) -o codebook_search
//   ./codebook_search
#include <ccvt/ccvt.h>

#include <algorithm>
#include <iostream>
#include <numeric>
#include <random>
#include <vector>

constexpr int lists = 64, probes = 4, neighbours = 10;

/// `count` vectors of 16 dimensions in 100 clouds, some large, most small.
Eigen::MatrixXf made_up(int count, unsigned seed) {
  std::mt19937 same(1), random(seed);
  std::normal_distribution<float> normal;
  std::geometric_distribution<int> cloud(0.05);
  const auto centres = Eigen::MatrixXf::NullaryExpr(16, 100, [&] { return normal(same); }).eval();
  Eigen::MatrixXf vectors(16, count);
  for (auto vector : vectors.colwise()) {
    vector = centres.col(std::min(cloud(random), 99));
    for (float& x : vector) x += 0.5F * normal(random);
  }
  return vectors;
}

/// The `count` of the candidates, or fewer, that are nearest to the query, the nearest first.
std::vector<ccvt::Index> nearest(const Eigen::MatrixXf& vectors, const Eigen::VectorXf& query,
                                 std::vector<ccvt::Index> candidates, int count) {
  const auto end = candidates.begin() + std::min<std::ptrdiff_t>(count, std::ssize(candidates));
  std::partial_sort(candidates.begin(), end, candidates.end(), [&](auto a, auto b) {
    return (vectors.col(a) - query).squaredNorm() < (vectors.col(b) - query).squaredNorm();
  });
  candidates.erase(end, candidates.end());
  return candidates;
}

std::vector<ccvt::Index> numbers_to(int count) {
  std::vector<ccvt::Index> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

int main() {
  const Eigen::MatrixXf vectors = made_up(20'000, 2), queries = made_up(200, 3);
  const auto [codebook, codes, summary] = ccvt::train_codebook(vectors, lists, {.effort = 0});
  const ccvt::Tessellation inverted(codes, lists);  // the vectors of each list
  const Eigen::MatrixXf words = codebook.codewords().cast<float>();

  std::size_t scanned = 0;
  std::ptrdiff_t found = 0;
  for (const Eigen::VectorXf query : queries.colwise()) {
    std::vector<ccvt::Index> candidates;
    for (const auto list : nearest(words, query, numbers_to(lists), probes)) {
      const auto members = inverted.cell(list);
      candidates.insert(candidates.end(), members.begin(), members.end());
    }
    scanned += candidates.size();
    const auto answer = nearest(vectors, query, candidates, neighbours);
    for (const auto true_one : nearest(vectors, query, numbers_to(20'000), neighbours)) {
      found += std::count(answer.begin(), answer.end(), true_one);
    }
  }
  std::cout << summary.brief() << "\nlongest list " << summary.usage.largest << ", shortest "
            << summary.usage.smallest << "\nscanned " << scanned / 200 << " of 20000\nrecall "
            << double(found) / (200 * neighbours) << "\n";
}

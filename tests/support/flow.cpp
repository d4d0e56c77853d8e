#include "support/flow.h"

#ifdef CCVT_TEST_FLOW

#include <lemon/network_simplex.h>
#include <lemon/smart_graph.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace ccvt::test {

double least_cost(const Points<float>& points, const std::vector<double>& sites,
                  const std::vector<Index>& capacities) {
  using Graph = lemon::SmartDigraph;
  Graph graph;
  std::vector<Graph::Node> from;
  std::vector<Graph::Node> to;
  for (Eigen::Index p = 0; p < points.cols(); ++p) from.push_back(graph.addNode());
  for (std::size_t s = 0; s < capacities.size(); ++s) to.push_back(graph.addNode());
  // In whole numbers: with rounding, the simplex can cycle among ties.
  Graph::ArcMap<std::int64_t> cost(graph);
  std::vector<double> squared;
  Graph::NodeMap<int> supply(graph);
  for (std::size_t p = 0; p < from.size(); ++p) supply[from[p]] = 1;
  for (std::size_t s = 0; s < to.size(); ++s) {
    supply[to[s]] = -capacities[s];
    for (std::size_t p = 0; p < from.size(); ++p) {
      double sum = 0;
      for (Eigen::Index d = 0; d < points.rows(); ++d) {
        const double difference =
            static_cast<double>(points(d, static_cast<Eigen::Index>(p))) -
            sites[s * static_cast<std::size_t>(points.rows()) + static_cast<std::size_t>(d)];
        sum += difference * difference;
      }
      squared.push_back(sum);
    }
  }
  const double largest = *std::max_element(squared.begin(), squared.end());
  const double scale = largest > 0 ? 0x1p44 / largest : 1;
  std::size_t k = 0;
  for (std::size_t s = 0; s < to.size(); ++s) {
    for (const auto& node : from) {
      cost[graph.addArc(node, to[s])] = std::llround(squared[k++] * scale);
    }
  }
  lemon::NetworkSimplex<Graph, int, std::int64_t> simplex(graph);
  if (simplex.costMap(cost).supplyMap(supply).run() != simplex.OPTIMAL) {
    throw std::logic_error("flow oracle: no optimum");
  }
  return simplex.totalCost<double>() / scale;
}

}  // namespace ccvt::test

#endif

#pragma once

#include <string>
#include <vector>

namespace ccvt::cli {

/// Of `known`, the word that `typed` was most likely meant to be: the one that it begins, or that
/// the fewest letters left out, put in, changed or exchanged with their neighbour lead to, one in
/// three letters at most. Empty: none, or no single best one.
std::string likely_meant(const std::string& typed, const std::vector<std::string>& known);

}  // namespace ccvt::cli

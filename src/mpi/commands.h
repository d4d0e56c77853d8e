#pragma once

#include "cli/arguments.h"
#include "session.h"

/// Commands of ccvt-mpi, each run by all ranks together. They throw Failure, and InvalidInput on
/// all ranks.
namespace ccvt::mpi {

int run_quantize(const Session& session, const cli::QuantizeArguments& given);
int run_sample(const Session& session, const cli::SampleArguments& given);
int run_tessellate(const Session& session, const cli::TessellateArguments& given);
int run_encode(const Session& session, const cli::EncodeArguments& given);
int run_volume(const Session& session, const cli::VolumeArguments& given);

}  // namespace ccvt::mpi

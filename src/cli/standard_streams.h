#pragma once

#include <filesystem>
#include <string>

#include "ccvt/publication.h"
#include "io/formats.h"

/// Files named `-` or `FORMAT:-`, which are standard input and standard output. The library knows
/// files only: for each stream a file of a temporary directory stands in, which is filled before it
/// is read, and sent when it is whole. One input and one output may be a stream.
namespace ccvt::cli {

enum class Stream { input, output };

/// From now on stand_in() throws InvalidInput: `program` knows files only.
void refuse_streams(const std::string& program);
[[nodiscard]] bool streams_are_refused();
/// The program that runs: ccvt, or what refuses streams.
[[nodiscard]] std::string program_name();

/// "-", or "npy:-".
bool names_stream(const std::string& text);

/// The file of one of `extensions` that stands in for what `text`, of which names_stream() holds,
/// names; of none where there are no extensions. "-" is csv, or the first where that is not among
/// them. Throws InvalidInput when another `option` has the stream, or the format is unknown, needs
/// more than a stream, or is binary and for a terminal; IoError.
std::filesystem::path stand_in(const std::string& option, const std::string& text, Stream stream,
                               io::Extensions extensions);

/// What `text` names: a file, or that which stands in for a stream.
std::filesystem::path file_of(const std::string& option, const std::string& text, Stream stream,
                              io::Extensions extensions);

/// Whether `file` stands in for standard input.
bool is_from_stream(const std::filesystem::path& file);

/// Reads all of standard input, where it has a stand-in, the first time that it is called. Throws
/// IoError.
void receive_standard_input();

/// Sends the unpublished stand-in of standard output, if there is one, there, and waits for who
/// reads it. Throws IoError, when part of it may have been sent.
void send_standard_output(const Publication& outputs);

/// Whether a file goes to standard output, so that nothing else may.
bool standard_output_is_taken();

/// `message` with the streams' names for those of their stand-ins; where the one for standard
/// output cannot be written, it is called a copy, and its directory named.
std::string with_names_of_streams(std::string message);

}  // namespace ccvt::cli

// The two sides of a viewing session: requests by name, and the client that reads their answers. The HTTP server sits
// between both and knows nothing else.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace kiln {

/// The reader of an answer: a document, or a stream of records.
class ViewClient {
 public:
  virtual ~ViewClient() = default;
  /// Sends the whole answer. throws: Error kCancelled if nobody reads.
  virtual void document(std::string_view type, std::span<const std::byte> bytes) = 0;
  /// Sends a record: one line of JSON and perhaps a picture. throws: as document.
  virtual void record(std::string_view json, std::span<const std::byte> payload) = 0;
  /// True once nobody reads the answer. thread: any.
  virtual bool gone() const = 0;
};

class ViewService {
 public:
  enum class Request { kUnknown, kReads, kPosts };
  virtual ~ViewService() = default;
  /// Returns whether a request of this name exists, and has a body.
  virtual Request kindOf(std::string_view name) const = 0;
  /// Answers a request. `body` is JSON. thread: several at once. throws: Error; kUsage and kFormat for requests that
  /// are wrong in themselves, kCancelled if nobody reads the answer.
  virtual void answer(std::string_view name, const std::string& body, ViewClient& client) = 0;
  /// Ends what is being drawn, and refuses further requests. thread: any.
  virtual void stop() = 0;
};

}  // namespace kiln

// A client that keeps what a session sends, and may leave at any time.
#pragma once

#include <atomic>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "view/view_client.h"

namespace kiln::test {

class RecordedClient final : public ViewClient {
 public:
  struct Record {
    nlohmann::json json;
    std::vector<std::byte> payload;
  };

  void document(std::string_view type, std::span<const std::byte> bytes) override {
    document_type = type;
    document_bytes.assign(bytes.begin(), bytes.end());
  }
  void record(std::string_view json, std::span<const std::byte> payload) override {
    if (left) throw Error(ErrorCode::kCancelled, "the client has left");
    records.push_back({nlohmann::json::parse(json), {payload.begin(), payload.end()}});
    if (on_record) on_record(records.back());
  }
  bool gone() const override { return left || (leaves && leaves()); }

  /// Returns the JSON of the answer's document.
  nlohmann::json json() const {
    return nlohmann::json::parse(reinterpret_cast<const char*>(document_bytes.data()),
                                 reinterpret_cast<const char*>(document_bytes.data()) + document_bytes.size());
  }
  /// Returns the kinds of the records in their order; of pictures, the stage.
  std::vector<std::string> kinds() const {
    std::vector<std::string> out;
    for (const Record& record : records) {
      const std::string kind = record.json.at("kind");
      if (kind != "progress") out.push_back(kind == "picture" ? record.json.at("stage") : record.json.at("kind"));
    }
    return out;
  }
  const Record* stage(const std::string& name) const {
    for (const Record& record : records)
      if (record.json.value("stage", "") == name) return &record;
    return nullptr;
  }

  std::function<void(const Record&)> on_record;
  std::function<bool()> leaves;
  std::atomic<bool> left = false;
  std::string document_type;
  std::vector<std::byte> document_bytes;
  std::vector<Record> records;
};

}  // namespace kiln::test

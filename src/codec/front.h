// The front of a region-growing traversal: the loops of edges between the faces that are known and those that are not
// (BITSTREAM.md, section 5.1).
//
// A node stands for one edge of a loop and for the vertex where that edge starts. Edges run with the unknown side on
// their left. Between a node's edge and the one before it lies a sector of unknown faces at the vertex; its free
// valence is the number of edges within that sector, so the faces there are one more. A vertex has a node for each of
// its unknown sectors, and a face that splits a sector makes two nodes of one. Whether that splits a loop in two or
// merges two loops (a handle) comes out of the links and needs no care.
//
// Nodes are kept in a queue by free valence, first in first out among equals. Dummy vertices are in it only when their
// free valence is 0, so that no vertex is met first from the middle of a hole.
//
// Everything here is O(1). Nothing here checks validity; the traversal does.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace tsc {

class Front {
 public:
  struct alignas(32) Node {
    std::uint32_t next = 0;  ///< along the loop; next free node when unused
    std::uint32_t previous = 0;
    std::uint32_t queue_next = 0;  ///< circular lists through their sentinel; itself when not queued
    std::uint32_t queue_previous = 0;
    std::uint32_t free_valence = 0;
    std::uint32_t corner = 0;   ///< corner of the known face that faces the edge
    std::uint32_t vertex = 0;   ///< kUnused when the node is not in use
    std::uint16_t degree_class = 0;  ///< of the vertex: min(degree, 15); 0 for dummies
    std::uint16_t facing_class = 0;  ///< degree class of the vertex at `corner`
  };
  static constexpr std::uint32_t kUnused = 0xffffffffu;
  static constexpr std::uint32_t kNoNode = 0;  ///< never in use, but may be looked at
  static constexpr std::uint32_t kBucketCount = 64;

  Front() {
    nodes_.reserve(1024);
    for (std::uint32_t b = 0; b < kBucketCount; ++b) nodes_.push_back({0, 0, b, b, 0, 0, kUnused, 0, 0});
  }

  Node& operator[](std::uint32_t node) { return nodes_[node]; }
  const Node& operator[](std::uint32_t node) const { return nodes_[node]; }

  bool isDummy(std::uint32_t node) const { return nodes_[node].degree_class == 0; }
  bool hasPivot() const { return occupied_ != 0; }
  bool empty() const { return active_count_ == 0; }

  /// The node of smallest free valence (63 and more count as equal), the one that has waited longest among equals.
  std::uint32_t pivot() const {
    return nodes_[static_cast<std::uint32_t>(std::countr_zero(occupied_))].queue_next;
  }

  /// Slots are numbered by first use and reused last in first out; all in use are below slotCount().
  std::uint32_t slotCount() const { return static_cast<std::uint32_t>(nodes_.size()) - kBucketCount; }
  static std::uint32_t slotOf(std::uint32_t node) { return node - kBucketCount; }
  static std::uint32_t nodeAt(std::uint32_t slot) { return slot + kBucketCount; }
  bool isUsed(std::uint32_t node) const { return nodes_[node].vertex != kUnused; }

  /// A new node outside any loop and outside the queue.
  std::uint32_t add(std::uint32_t vertex, std::uint32_t degree_class, std::uint32_t free_valence) {
    std::uint32_t node = unused_;
    if (node != 0) {
      unused_ = nodes_[node].next;
    } else {
      node = static_cast<std::uint32_t>(nodes_.size());
      nodes_.emplace_back();
    }
    ++active_count_;
    nodes_[node] = {node, node, node, node, free_valence, 0, vertex, static_cast<std::uint16_t>(degree_class), 0};
    return node;
  }

  void remove(std::uint32_t node) {
    leaveQueue(node);
    nodes_[node].vertex = kUnused;
    nodes_[node].next = unused_;
    unused_ = node;
    --active_count_;
  }

  void link(std::uint32_t node, std::uint32_t next) {
    nodes_[node].next = next;
    nodes_[next].previous = node;
  }

  void setFreeValence(std::uint32_t node, std::uint32_t free_valence) {
    leaveQueue(node);
    nodes_[node].free_valence = free_valence;
    enterQueue(node);
  }

  void enterQueue(std::uint32_t node) {
    Node& entry = nodes_[node];
    if (entry.degree_class == 0 && entry.free_valence > 0) return;
    const std::uint32_t bucket = bucketOf(entry);
    const std::uint32_t last = nodes_[bucket].queue_previous;
    entry.queue_next = bucket;
    entry.queue_previous = last;
    nodes_[last].queue_next = node;
    nodes_[bucket].queue_previous = node;
    occupied_ |= std::uint64_t{1} << bucket;
  }

 private:
  static std::uint32_t bucketOf(const Node& node) { return std::min(node.free_valence, kBucketCount - 1); }

  void leaveQueue(std::uint32_t node) {
    Node& entry = nodes_[node];
    nodes_[entry.queue_previous].queue_next = entry.queue_next;
    nodes_[entry.queue_next].queue_previous = entry.queue_previous;
    entry.queue_next = entry.queue_previous = node;
    // Without a branch, which could not be predicted: the bit says whether the sentinel has anyone but itself.
    const std::uint32_t bucket = bucketOf(entry);
    const std::uint64_t is_occupied = nodes_[bucket].queue_next != bucket;
    occupied_ = (occupied_ & ~(std::uint64_t{1} << bucket)) | is_occupied << bucket;
  }

  std::vector<Node> nodes_;  ///< the first kBucketCount are the queue's sentinels
  std::uint32_t unused_ = 0;
  std::uint32_t active_count_ = 0;
  std::uint64_t occupied_ = 0;  ///< bit b: bucket b is not empty
};

}  // namespace tsc

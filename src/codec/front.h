// The front of a region-growing traversal: the loops of edges between the faces that are known and those that are not
// (BITSTREAM.md, section 5.1).
//
// A node stands for one edge of a loop and for the vertex where that edge starts. Edges run with the unknown side on
// their left. Between a node's edge and the one before it lies a sector of unknown faces at the vertex; its free
// valence is the number of edges within that sector, so the faces there are one more. A vertex has a node for each of
// its unknown sectors, and a face that splits a sector makes two nodes of one. Whether that splits a loop in two or
// merges two loops (a handle) comes out of the links and needs no care.
//
// Four queues, first in first out, hold the nodes of free valence 0, 1, 2, and 3 or more. A node that changes is only
// added to its new queue; who takes from a queue passes over entries that no longer hold. That is several times cheaper
// than to keep linked lists.
//
// Everything here is O(1), averaged over all calls. Nothing here checks validity or room; the traversal does.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lanes.h"

namespace tsc {

class Front {
 public:
  struct alignas(32) Node {
    std::uint32_t link[2] = {};        ///< along the loop: [0] previous, [1] next (of unused nodes: next unused one)
    std::uint64_t identity = kUnused;  ///< count of nodes so far * 2^32 + number of the node; kUnused when not in use
    std::uint32_t free_valence = 0;
    std::uint32_t facing = 0;        ///< what faces the edge in the known face: a corner, or the vertex at it
    std::uint16_t degree_class = 0;  ///< of the vertex: min(degree, 15) - 1; kDummyClass for dummies
    std::uint16_t facing_class = 0;  ///< degree class of the vertex that faces the edge
    std::uint32_t vertex = 0;
    std::uint32_t previous() const { return link[0]; }
    std::uint32_t next() const { return link[1]; }
  };
  static constexpr std::uint64_t kUnused = ~std::uint64_t{0};
  static constexpr std::uint32_t kNoNode = 0xffffffffu;
  static constexpr std::uint32_t kDummyClass = 15;

  Node& operator[](std::uint32_t node) { return nodes_[node]; }
  const Node& operator[](std::uint32_t node) const { return nodes_[node]; }

  bool empty() const { return active_count_ == 0; }
  bool isUsed(std::uint32_t node) const { return nodes_[node].identity != kUnused; }

  /// Nodes are numbered by first use and reused last in first out; all in use are below nodeCount().
  std::uint32_t nodeCount() const { return node_count_; }

  /// Makes room for so many more nodes, and entries in each queue.
  void makeRoom(std::size_t nodes, std::size_t entries) {
    const std::size_t size = node_count_ + nodes;
    if (nodes_.size() < size) nodes_.resize(std::max(size, 2 * nodes_.size()));
    for (std::uint32_t index = 0; index <= kLastQueue; ++index) makeQueueRoom(index, entries);
  }

  /// A new node outside any loop and outside the queues.
  TSC_ALWAYS_INLINE std::uint32_t add(std::uint32_t vertex, std::uint32_t degree_class, std::uint32_t free_valence) {
    std::uint32_t node = unused_;
    if (node != kNoNode) [[likely]] {
      unused_ = nodes_[node].next();
    } else {
      node = node_count_++;
    }
    ++active_count_;
    nodes_[node].identity = std::uint64_t{serial_++} << 32 | node;
    nodes_[node].vertex = vertex;
    nodes_[node].free_valence = free_valence;
    nodes_[node].degree_class = static_cast<std::uint16_t>(degree_class);
    return node;
  }

  void remove(std::uint32_t node) {
    nodes_[node].identity = kUnused;
    nodes_[node].link[1] = unused_;
    unused_ = node;
    --active_count_;
  }

  void link(std::uint32_t node, std::uint32_t next) {
    nodes_[node].link[1] = next;
    nodes_[next].link[0] = node;
  }

  void setEdge(std::uint32_t node, std::uint32_t facing, std::uint32_t facing_class) {
    nodes_[node].facing = facing;
    nodes_[node].facing_class = static_cast<std::uint16_t>(facing_class);
  }

  void enterQueue(std::uint32_t node) {
    Queue& queue = queues_[queueOf(nodes_[node])];
    *queue.end++ = nodes_[node].identity;
  }

  /// The caller knows that it is not 0. A node whose queue stays the same keeps its place there.
  TSC_ALWAYS_INLINE void decrementFreeValence(std::uint32_t node) {
    Node& entry = nodes_[node];
    --entry.free_valence;
    const std::uint32_t index = queueOf(entry);
    Queue& queue = queues_[index];
    *queue.end = entry.identity;
    queue.end += kIsNew[index];  // without a branch, which could not be predicted
  }

  /// A node of free valence 0, the one that has waited longest; kNoNode if there is none.
  std::uint32_t takeClosable() { return takeFrom<0>(); }

  /// The node of the smallest free valence (3 and more count as equal), the one that has waited longest among equals.
  /// No dummy, so that no vertex is met first from the middle of a hole. The caller knows that none has 0.
  std::uint32_t takePivot() {
    std::uint32_t node = takeFrom<1>();
    if (node == kNoNode) node = takeFrom<2>();
    if (node == kNoNode) node = takeFrom<kLastQueue>();
    return node;
  }

 private:
  static constexpr std::uint32_t kLastQueue = 3;
  static constexpr std::uint32_t kIsNew[kLastQueue + 1] = {1, 1, 1, 0};  ///< by queue: it is not the one before

  struct Queue {
    std::uint64_t* next = nullptr;  ///< identities of nodes; those from here to `end` wait
    std::uint64_t* end = nullptr;
  };

  /// Whether an entry still holds. A number that is used anew has another identity.
  bool isWaiting(std::uint64_t entry, std::uint32_t index) const {
    const Node& node = nodes_[nodeOf(entry)];
    return (node.identity == entry) & (queueOf(node) == index) & (index == 0 || node.degree_class != kDummyClass);
  }

  template <std::uint32_t index>
  std::uint32_t takeFrom() {
    Queue& queue = queues_[index];
    for (; queue.next != queue.end; ++queue.next) {
      const std::uint64_t entry = *queue.next;
      const Node& node = nodes_[nodeOf(entry)];
      if (node.identity != entry || queueOf(node) != index) continue;
      if (index > 0 && node.degree_class == kDummyClass) continue;
      if (index < kLastQueue) ++queue.next;  // It may keep its place in the last.
      return nodeOf(entry);
    }
    return kNoNode;
  }

  /// Forgets the entries that no longer hold, and enlarges the storage if that does not free most of it.
  void makeQueueRoom(std::uint32_t index, std::size_t count) {
    Queue& queue = queues_[index];
    std::vector<std::uint64_t>& storage = storage_[index];
    // One more, because an entry that is not to stay is written, too.
    const auto used = static_cast<std::size_t>(queue.end - storage.data());
    if (storage.size() > used + count) return;
    std::size_t waiting = 0;
    for (const std::uint64_t* entry = queue.next; entry != queue.end; ++entry) {
      storage[waiting] = *entry;
      waiting += isWaiting(*entry, index);
    }
    if (storage.size() < 4 * (waiting + count + 1)) storage.resize(4 * (waiting + count + 1));
    queue.next = storage.data();
    queue.end = queue.next + waiting;
  }

  static std::uint32_t nodeOf(std::uint64_t identity) { return static_cast<std::uint32_t>(identity); }
  static std::uint32_t queueOf(const Node& node) { return std::min(node.free_valence, kLastQueue); }

  std::vector<Node> nodes_;
  std::array<Queue, kLastQueue + 1> queues_;
  std::array<std::vector<std::uint64_t>, kLastQueue + 1> storage_;  ///< of the queues
  std::uint32_t node_count_ = 0;
  std::uint32_t unused_ = kNoNode;
  std::uint32_t active_count_ = 0;
  std::uint32_t serial_ = 0;  ///< of the next node: fewer are made than there are faces
};

}  // namespace tsc

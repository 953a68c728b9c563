// The triangles with the nearest centroids: a balanced kd-tree over centroids, laid out in one array.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numeric>
#include <utility>
#include <vector>

namespace tsc {

class TriangleFinder {
 public:
  TriangleFinder(const std::vector<glm::dvec3>& positions, const std::vector<std::uint32_t>& indices) {
    centroids_.resize(indices.size() / 3);
    for (std::size_t t = 0; t < centroids_.size(); ++t) {
      for (int k = 0; k < 3; ++k) centroids_[t] += positions[indices[3 * t + k]] / 3.0;
    }
    order_.resize(centroids_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, order_.size(), 0);
  }

  /// Up to `count` triangles, nearest first; equally near ones by number.
  [[nodiscard]] std::vector<std::uint32_t> nearest(const glm::dvec3& point, std::size_t count) const {
    std::vector<Found> heap;  // the farthest on top
    search(point, count, 0, order_.size(), 0, heap);
    std::sort_heap(heap.begin(), heap.end());
    std::vector<std::uint32_t> result;
    for (const Found& found : heap) result.push_back(found.second);
    return result;
  }

 private:
  using Found = std::pair<double, std::uint32_t>;  // squared distance, triangle

  // The median of a range along `axis` stands in its middle, the lower half before it.
  void build(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t x, std::uint32_t y) {
                       const double u = centroids_[x][axis], v = centroids_[y][axis];
                       return u != v ? u < v : x < y;
                     });
    build(begin, middle, (axis + 1) % 3);
    build(middle + 1, end, (axis + 1) % 3);
  }

  void search(const glm::dvec3& point, std::size_t count, std::size_t begin, std::size_t end, int axis,
              std::vector<Found>& heap) const {
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const glm::dvec3 offset = point - centroids_[order_[middle]];
    const Found found{glm::dot(offset, offset), order_[middle]};
    if (heap.size() < count) {
      heap.push_back(found);
      std::push_heap(heap.begin(), heap.end());
    } else if (found < heap.front()) {
      std::pop_heap(heap.begin(), heap.end());
      heap.back() = found;
      std::push_heap(heap.begin(), heap.end());
    }
    const bool low_first = offset[axis] < 0;
    const int next = (axis + 1) % 3;
    if (low_first) search(point, count, begin, middle, next, heap);
    else search(point, count, middle + 1, end, next, heap);
    if (heap.size() < count || offset[axis] * offset[axis] <= heap.front().first) {
      if (low_first) search(point, count, middle + 1, end, next, heap);
      else search(point, count, begin, middle, next, heap);
    }
  }

  std::vector<glm::dvec3> centroids_;
  std::vector<std::uint32_t> order_;
};

}  // namespace tsc

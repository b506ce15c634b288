#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace marco::mapping3d {

using Cell = Eigen::Vector3i;  ///< of an unbounded lattice; sample (i, j, k) lies at i, j, k voxels

/// Sparse voxels: blocks of 8 x 8 x 8 samples in a hash table (open addressing), allocated on
/// demand. Cells within +-2^23. Blocks keep their addresses. Not thread-safe.
template <class Voxel>
class VoxelBlocks {
 public:
  static constexpr int kEdge = 8;
  struct Block {
    Cell corner;  ///< its lowest sample
    std::array<Voxel, 512> voxels;
  };

  VoxelBlocks() : slots_(1U << 10U) {}

  static std::size_t index_in_block(const Cell& cell) {
    return static_cast<std::size_t>((cell.x() & 7) | ((cell.y() & 7) << 3) | ((cell.z() & 7) << 6));
  }

  /// @returns nullptr without a block.
  Block* find(const Cell& cell) const {
    const uint64_t key = key_of(cell);
    for (std::size_t slot = hash(key);; slot = next(slot)) {
      if (slots_[slot].key == key) return slots_[slot].block;
      if (slots_[slot].key == kFree) return nullptr;
    }
  }
  Voxel* find_voxel(const Cell& cell) const {
    Block* block = find(cell);
    return block == nullptr ? nullptr : &block->voxels[index_in_block(cell)];
  }
  Block& at(const Cell& cell) {
    const uint64_t key = key_of(cell);
    std::size_t slot = hash(key);
    while (slots_[slot].key != kFree) {
      if (slots_[slot].key == key) return *slots_[slot].block;
      slot = next(slot);
    }
    blocks_.push_back(std::make_unique<Block>());
    Block* block = blocks_.back().get();
    block->corner = Cell(cell.x() & ~7, cell.y() & ~7, cell.z() & ~7);
    slots_[slot] = {key, block};
    if (2 * blocks_.size() > slots_.size()) grow();
    return *block;
  }
  Voxel& voxel(const Cell& cell) { return at(cell).voxels[index_in_block(cell)]; }

  /// Calls visit(voxel, t) for the voxels with a block at from + t * direction, t = 0, 1, ... to
  /// below `last`, all in voxels; the direction is of unit length. Goes over what has no block at
  /// once.
  template <class Visit>
  void walk(const Eigen::Vector3f& from,
            const Eigen::Vector3f& direction,
            float last,
            const Visit& visit) const {
    const Eigen::Vector3f inverse = direction.cwiseInverse();
    Block* block = nullptr;
    Cell corner = Cell::Constant(1);  // of no block
    for (float t = 0.0F; t < last;) {
      const Eigen::Vector3f at = from + t * direction;
      const Cell cell = (at.array() + 0.5F).floor().template cast<int>();
      const Cell own(cell.x() & ~7, cell.y() & ~7, cell.z() & ~7);
      if (own != corner) {
        corner = own;
        block = find(cell);
      }
      if (block != nullptr) {
        visit(block->voxels[index_in_block(cell)], t);
        t += 1.0F;
        continue;
      }
      float leave = last;  // where the ray leaves this block
      for (int axis = 0; axis < 3; ++axis) {
        const float wall =
            static_cast<float>(corner[axis]) - 0.5F + (direction[axis] > 0.0F ? 8.0F : 0.0F);
        if (direction[axis] != 0.0F) leave = std::min(leave, (wall - from[axis]) * inverse[axis]);
      }
      t = std::max(leave, t) + 0.01F;
    }
  }

  const std::vector<std::unique_ptr<Block>>& blocks() const { return blocks_; }
  /// Leaves none.
  std::vector<std::unique_ptr<Block>> take_blocks() {
    slots_.assign(1U << 10U, {});
    return std::exchange(blocks_, {});
  }

 private:
  static constexpr uint64_t kFree = ~uint64_t{0};
  struct Slot {
    uint64_t key = kFree;
    Block* block = nullptr;
  };
  static uint64_t part(int value) {
    return uint64_t{(1U << 20U) + static_cast<uint32_t>(value >> 3)};
  }
  static uint64_t key_of(const Cell& cell) {
    return part(cell.x()) | (part(cell.y()) << 21U) | (part(cell.z()) << 42U);
  }
  std::size_t hash(uint64_t key) const {
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20U) & (slots_.size() - 1);
  }
  std::size_t next(std::size_t slot) const { return (slot + 1) & (slots_.size() - 1); }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& from : old) {
      if (from.key == kFree) continue;
      std::size_t slot = hash(from.key);
      while (slots_[slot].key != kFree) slot = next(slot);
      slots_[slot] = from;
    }
  }

  std::vector<Slot> slots_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

}  // namespace marco::mapping3d

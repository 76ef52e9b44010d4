// Frames of the leaves demo: the tree and its leaves, and beside them the same with the PCS in red.
#ifndef QC_DEMOS_LEAVES_PICTURE_H
#define QC_DEMOS_LEAVES_PICTURE_H

#include "common/bullet/demo_frame.h"
#include "leaves/world.h"

/// Flags of the triangles in the PCS.
struct qcLeavesMarks
{
    std::vector<uint8_t> tree;
    std::vector<std::vector<uint8_t>> leaves;
};

class qcLeavesPicture
{
  public:
    explicit qcLeavesPicture(const qcLeavesWorld& world);

    /// Writes a PNG. False with a message.
    bool Write(qcDevice* device, const qcLeavesWorld& world, const qcLeavesMarks& marks, const std::string& path,
               std::string* message);

  private:
    qcDemoFrame m_frame;
    std::vector<float> m_treePositions;
    std::vector<std::vector<float>> m_positions; ///< of each leaf
};

#endif

// Frames of the breaking demo: the scene, and beside it the PCS in red.
#ifndef QC_DEMOS_BREAKING_PICTURE_H
#define QC_DEMOS_BREAKING_PICTURE_H

#include "breaking/world.h"
#include "common/bullet/demo_frame.h"

/// The PCS of a frame: a flag for each triangle of a shape; empty: none is drawn.
struct qcBreakingMarks
{
    std::vector<uint8_t> bunny;
    std::vector<std::vector<uint8_t>> pieces;
};

class qcBreakingPicture
{
  public:
    qcBreakingPicture();
    /// Writes a PNG. False with a message.
    bool Write(qcDevice* device, const qcBreakingWorld& world, const qcBreakingMarks& marks, const std::string& path,
               std::string* message);

  private:
    qcDemoFrame m_frame;
};

#endif

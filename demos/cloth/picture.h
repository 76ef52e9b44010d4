// Frames of the cloth demo: the cloth, and beside it the same cloth with the PCS in red.
#ifndef QC_DEMOS_CLOTH_PICTURE_H
#define QC_DEMOS_CLOTH_PICTURE_H

#include "common/bullet/demo_frame.h"

class qcClothPicture
{
  public:
    qcClothPicture();

    /// Writes a PNG. Empty `marked`: the left half alone. False with a message.
    bool Write(qcDevice* device, const std::vector<float>& positions, const std::vector<uint32_t>& indices,
               const std::vector<uint8_t>& marked, const std::string& path, std::string* message);

  private:
    qcDemoFrame m_frame;
    std::vector<float> m_tablePositions;
    std::vector<uint32_t> m_tableIndices;
};

#endif

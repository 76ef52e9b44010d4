// Frames of the cloth demo: the cloth, and beside it the same cloth with the PCS in red.
#ifndef QC_DEMOS_CLOTH_PICTURE_H
#define QC_DEMOS_CLOTH_PICTURE_H

#include "common/bullet/demo_frame.h"

class qcClothPicture
{
  public:
    qcClothPicture();

    /// Moves the camera after the cloth that is pulled away. 0: the first act's camera; 1: the second act's at its end.
    void Follow(float part);
    /// Draws the bar that pulls the cloth in the following pictures, at this place; null: none.
    void SetGrip(const btVector3* middle);
    /// Writes a PNG. Empty `marked`: the left half alone. False with a message.
    bool Write(qcDevice* device, const std::vector<float>& positions, const std::vector<uint32_t>& indices,
               const std::vector<uint8_t>& marked, const std::string& path, std::string* message);

  private:
    qcDemoFrame m_frame;
    std::vector<float> m_tablePositions, m_gripPositions;
    std::vector<uint32_t> m_tableIndices, m_gripIndices;
};

#endif

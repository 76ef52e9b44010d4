// Frames of the cloth demo: the cloth, and beside it the same cloth with the PCS in red.
#ifndef QC_DEMOS_CLOTH_PICTURE_H
#define QC_DEMOS_CLOTH_PICTURE_H

#include "quickcullide/quickcullide.h"

#include <string>
#include <vector>

class qcClothPicture
{
  public:
    qcClothPicture();

    /// Writes a PNG. Empty `marked`: the left half alone. False with a message.
    bool Write(qcDevice* device, const std::vector<float>& positions, const std::vector<uint32_t>& indices,
               const std::vector<uint8_t>& marked, const std::string& path, std::string* message);

  private:
    bool Draw(qcDevice* device, const qcPictureMesh& cloth, uint32_t left, std::string* message);

    std::vector<float> m_furniturePositions; ///< table and floor
    std::vector<uint32_t> m_tableIndices, m_floorIndices;
    std::vector<uint8_t> m_image;
    uint32_t m_width = 0; ///< of the image
};

#endif

// Frames of the fracture demo: the body, or its pieces in colours of their own, cuts darker, on a tiled floor.
#ifndef QC_DEMOS_FRACTURE_PICTURE_H
#define QC_DEMOS_FRACTURE_PICTURE_H

#include "fracture/body.h"

#include "quickcullide/quickcullide.h"

#include <memory>
#include <string>
#include <vector>

class qcFracturePicture
{
  public:
    qcFracturePicture();

    /// Writes a PNG. False with a message.
    bool Write(qcDevice* device, const std::vector<std::unique_ptr<qcFractureBody>>& bodies, const std::string& path,
               std::string* message);

  private:
    std::vector<float> m_floor;
    std::vector<uint32_t> m_lightTiles, m_darkTiles;
};

#endif

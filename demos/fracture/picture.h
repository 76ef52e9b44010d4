// Frames of the fracture demo: the body, or its pieces in colours of their own, on a tiled floor. Faces inside are
// darker, in the colour of their cut: those that fitted have the same.
#ifndef QC_DEMOS_FRACTURE_PICTURE_H
#define QC_DEMOS_FRACTURE_PICTURE_H

#include "common/bullet/demo_frame.h"
#include "fracture/body.h"

#include <memory>

class qcFracturePicture
{
  public:
    qcFracturePicture();

    /// Writes a PNG. False with a message.
    bool Write(qcDevice* device, const std::vector<std::unique_ptr<qcFractureBody>>& bodies, const std::string& path,
               std::string* message);

  private:
    qcDemoFrame m_frame;
};

#endif

// One frame of a demo: meshes on a ground, and beside them the same in greys with the PCS in red; after figures 4 to 6
// of Govindaraju, Lin, Manocha: Quick-CULLIDE, VR 2005.
#ifndef QC_DEMOS_COMMON_BULLET_DEMO_FRAME_H
#define QC_DEMOS_COMMON_BULLET_DEMO_FRAME_H

#include "common/bullet/demo_picture.h"

#include <LinearMath/btTransform.h>

#include <deque>

/// A mesh of a frame. Its arrays stay the caller's, and are read when the frame is written.
struct qcFrameMesh
{
    const float* positions = nullptr; ///< in world space, three floats a vertex, tightly packed
    uint32_t vertexCount = 0;
    const uint32_t* indices = nullptr; ///< three a triangle
    uint32_t triangleCount = 0;
    float color[3] = {0.62f, 0.55f, 0.45f};     ///< of front faces, linear RGB in 0..1
    float backColor[3] = {0.62f, 0.55f, 0.45f}; ///< of back faces
    bool smooth = false;                        ///< normals averaged around each vertex; otherwise flat
    /// A flag for each triangle, nonzero: it is in the PCS. Null: the mesh has none. If a mesh of the frame has flags,
    /// the frame gets its right half.
    const uint8_t* pcs = nullptr;
    /// A table, a floor: at the right it keeps its brightness, and what moves is lighter than it.
    bool isScenery = false;

    void SetTriangles(const std::vector<float>& newPositions, const std::vector<uint32_t>& newIndices)
    {
        positions = newPositions.data();
        vertexCount = uint32_t(newPositions.size() / 3);
        indices = newIndices.data();
        triangleCount = uint32_t(newIndices.size() / 3);
    }
};

struct qcFrameCamera
{
    float eye[3] = {0, 1, 5};
    float target[3] = {0, 0, 0};
    float fieldOfView = 35; ///< vertical, in degrees
};

/// A horizontal plane that fades into the background.
struct qcFrameGround
{
    bool isDrawn = true;
    float height = 0;
    float color[3] = {0.55f, 0.56f, 0.57f};
    float tile = 0;   ///< width of the tiles of a chequered ground; 0: plain
    float extent = 0; ///< distance from the middle of the picture at which it has faded; 0: chosen from the camera
};

///     qcDemoFrame frame(800, 640);
///     qcSet3(frame.camera.eye, 3, 2, 5);
///     ... and for each picture:
///     frame.Clear();
///     frame.Add(mesh);
///     if (!frame.Write(device, path, &message))
class qcDemoFrame
{
  public:
    /// `width` and `height`: pixels of the left half, which is the whole picture without flags.
    qcDemoFrame(uint32_t width, uint32_t height) : m_width(width), m_height(height)
    {
    }

    qcFrameCamera camera;
    qcFrameGround ground;
    float background[3] = {0.80f, 0.82f, 0.84f}; ///< linear RGB in 0..1
    float light[3] = {0, 0, 0};                  ///< towards the light; 0: above the eye, from its left

    /// Removes all meshes and positions.
    void Clear();
    void Add(const qcFrameMesh& mesh)
    {
        m_meshes.push_back(mesh);
    }
    /// Positions of a rigid body's vertices in world space, for qcFrameMesh::positions. Valid until Clear.
    const float* Place(const btVector3* vertices, size_t count, const btTransform& place);

    /// Draws and writes a PNG. False with a message.
    bool Write(qcDevice* device, const std::string& path, std::string* message);

  private:
    bool Draw(qcDevice* device, bool showsPcs, uint32_t left, uint32_t imageWidth, std::string* message);

    uint32_t m_width, m_height;
    std::vector<qcFrameMesh> m_meshes;
    std::deque<std::vector<float>> m_placed; ///< a deque: what Place has returned stays where it is
    std::vector<qcPictureMesh> m_pictureMeshes;
    std::vector<uint8_t> m_image;
};

/// A colour for each piece of a broken body: hues a golden section apart, none of them strong.
void qcPieceColor(size_t index, float color[3]);

#endif

// Draws a frame with OpenGL 3.3: surfaces with a sun and its shadows over a ground, and debug lines.
#ifndef QC_DEMOS_VIEW_RENDERER_H
#define QC_DEMOS_VIEW_RENDERER_H

#include "view/camera.h"
#include "view/geometry.h"
#include "view/overlay.h"
#include "view/viewed_scene.h"

/// What to draw of one surface.
struct qcViewItem
{
    const qcViewSurface* surface;
    qcViewColors colors;
    bool selected;
};

struct qcViewFrame
{
    const qcViewCamera* camera;
    std::vector<qcViewItem> items;
    const qcViewOverlay *marks, *lines; ///< triangles of the first, lines of the second
    btVector3 lower, upper;             ///< around all that throws a shadow
    int width, height;                  ///< pixels
};

class qcViewRenderer
{
  public:
    ~qcViewRenderer();

    /// Needs a current context. False with a message.
    bool Create(std::string* message);
    void Draw(const qcViewFrame& frame);

  private:
    /// Triangles on the device.
    struct Buffer
    {
        unsigned vertexArray = 0, vertices = 0;
        int count = 0;
        uint64_t changes = 0;
        bool used = false;
    };

    const Buffer& Upload(const qcViewTriangles& triangles);
    void ReleaseUnused();
    void DrawShadows(const qcViewFrame& frame, const qcMatrix& light);
    void DrawSurfaces(const qcViewFrame& frame, const qcMatrix& viewProjection, const qcMatrix& light);
    void DrawColored(const std::vector<qcColoredVertex>& vertices, unsigned mode, const qcMatrix& viewProjection,
                     float alpha);

    unsigned m_surfaceProgram = 0, m_shadowProgram = 0, m_coloredProgram = 0, m_skyProgram = 0;
    unsigned m_shadowMap = 0, m_shadowTarget = 0;
    unsigned m_coloredArray = 0, m_coloredVertices = 0, m_emptyArray = 0;
    std::map<uint64_t, Buffer> m_buffers;
};

#endif

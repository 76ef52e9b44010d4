// Debug lines and triangles, collected for the window.
#ifndef QC_DEMOS_VIEW_OVERLAY_H
#define QC_DEMOS_VIEW_OVERLAY_H

#include <LinearMath/btIDebugDraw.h>

#include <vector>

struct qcColoredVertex
{
    float position[3], color[3]; ///< sRGB
};

class qcViewOverlay : public btIDebugDraw
{
  public:
    /// `size`: of crosses and normals of contact points, in world units.
    void Begin(btScalar size);
    /// Leaves out triangles in the plane through a point until the next Begin: a ground hides nothing by its marks.
    void LeaveOut(const btVector3& point, const btVector3& normal);
    /// Two vertices a line.
    const std::vector<qcColoredVertex>& Lines() const
    {
        return m_lines;
    }
    /// Three vertices a triangle.
    const std::vector<qcColoredVertex>& Triangles() const
    {
        return m_triangles;
    }

    using btIDebugDraw::drawLine;
    void drawLine(const btVector3& from, const btVector3& to, const btVector3& color) override;
    using btIDebugDraw::drawTriangle;
    void drawTriangle(const btVector3& a, const btVector3& b, const btVector3& c, const btVector3& color,
                      btScalar) override;
    void drawContactPoint(const btVector3& point, const btVector3& normal, btScalar distance, int lifeTime,
                          const btVector3& color) override;
    void reportErrorWarning(const char*) override
    {
    }
    void draw3dText(const btVector3&, const char*) override
    {
    }
    void setDebugMode(int) override
    {
    }
    int getDebugMode() const override
    {
        return DBG_DrawWireframe;
    }
    DefaultColors getDefaultColors() const override;

  private:
    struct Plane
    {
        btVector3 point, normal;
    };

    btScalar m_size = 1;
    std::vector<Plane> m_leftOut;
    std::vector<qcColoredVertex> m_lines, m_triangles;
};

#endif

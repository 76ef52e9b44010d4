// A btIDebugDraw that records its calls, for tests.
#ifndef QC_TESTS_BULLET_DEBUG_RECORDER_H
#define QC_TESTS_BULLET_DEBUG_RECORDER_H

#include <LinearMath/btIDebugDraw.h>

#include <array>
#include <vector>

class qcDebugRecorder : public btIDebugDraw
{
  public:
    struct Line
    {
        btVector3 from, to, color;
    };
    struct Box
    {
        btVector3 lower, upper, color;
    };
    struct Triangle
    {
        std::array<btVector3, 3> corners;
        btVector3 color;
    };
    struct Point
    {
        btVector3 onB, normal;
        btScalar distance;
    };

    std::vector<Line> lines;
    std::vector<Box> boxes;
    std::vector<Triangle> triangles;
    std::vector<Point> points;
    int flushes = 0;
    int mode = DBG_NoDebug;

    void Clear()
    {
        lines.clear();
        boxes.clear();
        triangles.clear();
        points.clear();
        flushes = 0;
    }

    using btIDebugDraw::drawLine;
    void drawLine(const btVector3& from, const btVector3& to, const btVector3& color) override
    {
        lines.push_back({from, to, color});
    }

    using btIDebugDraw::drawTriangle;
    void drawTriangle(const btVector3& a, const btVector3& b, const btVector3& c, const btVector3& color,
                      btScalar) override
    {
        triangles.push_back({{a, b, c}, color});
    }

    void drawAabb(const btVector3& lower, const btVector3& upper, const btVector3& color) override
    {
        boxes.push_back({lower, upper, color});
    }

    void drawContactPoint(const btVector3& onB, const btVector3& normal, btScalar distance, int,
                          const btVector3&) override
    {
        points.push_back({onB, normal, distance});
    }

    void flushLines() override
    {
        flushes++;
    }

    void reportErrorWarning(const char*) override
    {
    }

    void draw3dText(const btVector3&, const char*) override
    {
    }

    void setDebugMode(int debugMode) override
    {
        mode = debugMode;
    }

    int getDebugMode() const override
    {
        return mode;
    }
};

#endif

// The live window: GLFW's window and events, a step a frame, the scene, debug lines and the panels.
#include "view/view.h"

#include "view/panels.h"
#include "view/renderer.h"

#include "common/exit_status.h"
#include "common/interrupt.h"
#include "common/png_file.h"
#include "common/stopwatch.h"

// Before GLFW, which includes GL's headers.
#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace
{
std::string s_glfwMessage;
std::vector<int> s_keys; ///< pressed since the last frame, also if it has been released already

void TakeGlfwError(int, const char* text)
{
    s_glfwMessage = text;
}

void TakeKey(GLFWwindow*, int key, int, int action, int)
{
    if (action != GLFW_RELEASE)
        s_keys.push_back(key);
}

int Fail(int status, const std::string& message)
{
    std::fprintf(stderr, "%s: %s\n", program_invocation_short_name, message.c_str());
    return status;
}

/// The window and the contexts of GL and Dear ImGui, in this order.
class Window
{
  public:
    ~Window();
    bool Open(const char* title, bool waits, std::string* message);
    GLFWwindow* Get() const
    {
        return m_window;
    }

  private:
    GLFWwindow* m_window = nullptr;
    bool m_isReady = false, m_hasPanels = false;
};

Window::~Window()
{
    if (m_hasPanels)
    {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    if (m_window != nullptr)
        glfwDestroyWindow(m_window);
    if (m_isReady)
        glfwTerminate();
}

/// `waits`: for the screen, from frame to frame.
bool Window::Open(const char* title, bool waits, std::string* message)
{
    glfwSetErrorCallback(TakeGlfwError);
    m_isReady = glfwInit() == GLFW_TRUE;
    if (m_isReady)
    {
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_SAMPLES, 4);
        m_window = glfwCreateWindow(1280, 800, title, nullptr, nullptr);
    }
    if (m_window == nullptr)
    {
        *message = "--view: no window with OpenGL 3.3 opens here: " + s_glfwMessage;
        return false;
    }
    glfwMakeContextCurrent(m_window);
    glfwSwapInterval(waits ? 1 : 0);
    ImGui::CreateContext();
    qcStylePanels();
    // Dear ImGui's own callback calls it.
    glfwSetKeyCallback(m_window, TakeKey);
    ImGui_ImplGlfw_InitForOpenGL(m_window, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    m_hasPanels = true;
    return true;
}

class View
{
  public:
    View(qcViewedScene* scene, const qcViewOptions& options, qcDevice* device);
    int Run();

  private:
    void Handle();
    void HandleMouse();
    void HandleKey(int key);
    void Pick(btScalar x, btScalar y);
    void BeginWorld();
    void Restart();
    void ChangeSetting();
    void Step();
    void ReadGeometry();
    void Cull();
    void CollectMarks();
    void AddMark(const qcViewSurface& surface, uint32_t triangle, const btVector3& color);
    void CollectLines();
    qcViewColors ColorsOf(const qcViewSurface& surface) const;
    void Draw();
    bool WriteScreenshot(std::string* message);
    void CountFrame();

    qcViewedScene* m_scene;
    qcViewOptions m_options;
    Window m_window;
    std::unique_ptr<qcViewRenderer> m_renderer; ///< before the window's context ends
    qcViewState m_state;
    qcViewCamera m_camera;
    qcViewGeometry m_geometry;
    qcViewCulling m_culling;
    qcViewOverlay m_marks, m_lines;
    qcViewCosts m_costs;
    std::vector<qcViewSetting> m_settings;
    std::unique_ptr<qcDebugDraw> m_drawing;
    uint64_t m_changes = 0, m_culled = 0; ///< number of the present state, and of the one last culled
    qcViewRequest m_culledRequest;
    bool m_placed = false; ///< the camera
    double m_frameStart = 0;
    ImVec2 m_pressed{0, 0};
};

View::View(qcViewedScene* scene, const qcViewOptions& options, qcDevice* device)
    : m_scene(scene), m_options(options), m_culling(device)
{
    qcDeviceInfo info;
    m_state.hasGl = qcDevice_GetInfo(device, &info) == qc_statusOk && info.kind != qc_deviceNone;
    m_state.marks = options.marks;
    m_state.modes = options.modes;
}

/// Takes over a world that has just been made.
void View::BeginWorld()
{
    m_geometry.Clear();
    m_state.picked = nullptr;
    m_settings = m_scene->Settings();
    m_drawing = std::make_unique<qcDebugDraw>(&m_scene->World(), m_state.modes);
    m_scene->AddTo(m_drawing.get());
    m_changes++;
}

void View::Restart()
{
    m_drawing.reset();
    m_scene->Restart();
    m_costs.Clear();
    m_state.steps = 0;
    m_state.finished = false;
    m_state.message.clear();
    BeginWorld();
}

void View::ChangeSetting()
{
    m_drawing.reset();
    m_state.message = m_settings[m_state.changedSetting - 1].set(m_state.newValue);
    m_state.changedSetting = 0;
    BeginWorld();
}

void View::Step()
{
    if (m_state.finished || (m_state.paused && !m_state.stepOnce))
        return;
    m_state.stepOnce = false;
    m_drawing->setModes(m_state.modes);
    std::string message;
    if (!m_scene->Step(&message))
    {
        m_state.message = message;
        m_state.finished = m_state.paused = true;
    }
    m_costs.Add(m_scene->Costs());
    m_state.steps++;
    m_changes++;
}

void View::ReadGeometry()
{
    m_geometry.Update(m_scene->World());
    bool isThere = false;
    for (const qcViewSurface& surface : m_geometry.Surfaces())
        isThere = isThere || (surface.object == m_state.picked &&
                              surface.object->getBroadphaseHandle()->m_uniqueId == m_state.pickedId);
    if (!isThere)
        m_state.picked = nullptr;
    if (m_placed)
        return;
    m_placed = true;
    qcViewPlace place = m_scene->Place();
    btVector3 middle = (m_geometry.Lower() + m_geometry.Upper()) / 2;
    btScalar extent = (m_geometry.Upper() - m_geometry.Lower()).length();
    if (place.eye == place.target)
        m_camera.Place(middle + btVector3(btScalar(0.6), btScalar(0.5), btScalar(0.9)) * (btScalar(1.6) * extent),
                       middle);
    else
        m_camera.Place(place.eye, place.target);
}

/// Runs Quick-CULLIDE, if its sets are shown and the state has changed.
void View::Cull()
{
    if (m_state.marks < qc_marksQuick || !m_state.hasGl ||
        (m_culled == m_changes && m_culledRequest == m_state.request))
        return;
    std::string message;
    if (!m_culling.Run(m_geometry.Surfaces(), m_state.request, &message))
    {
        m_state.message = message;
        m_state.marks = qc_marksNone;
        return;
    }
    m_culled = m_changes;
    m_culledRequest = m_state.request;
}

void View::AddMark(const qcViewSurface& surface, uint32_t triangle, const btVector3& color)
{
    btVector3 corners[3];
    for (size_t c = 0; c < 3; c++)
    {
        const float* p =
            &surface.triangles->positions[3 * size_t(surface.triangles->indices[3 * size_t(triangle) + c])];
        corners[c] = surface.place * btVector3(p[0], p[1], p[2]);
    }
    m_marks.drawTriangle(corners[0], corners[1], corners[2], color, 1);
}

void View::CollectMarks()
{
    m_marks.Begin(1);
    for (const qcViewSurface& surface : m_geometry.Surfaces())
        if (surface.unbounded)
        {
            const qcShadedVertex& vertex = surface.triangles->shaded.front();
            m_marks.LeaveOut(surface.place * btVector3(vertex.position[0], vertex.position[1], vertex.position[2]),
                             surface.place.getBasis() *
                                 btVector3(vertex.normal[0], vertex.normal[1], vertex.normal[2]));
        }
    if (m_state.marks == qc_marksPcs)
    {
        m_drawing->setModes(qc_drawPcs);
        m_drawing->debugDraw(&m_marks);
        m_drawing->setModes(m_state.modes);
    }
    if (m_state.marks < qc_marksQuick || m_culled != m_changes)
        return;
    const std::vector<qcViewSurface>& surfaces = m_geometry.Surfaces();
    m_culling.ForEach(
        [&](size_t surface, uint32_t triangle, qcVisibilitySet set)
        { AddMark(surfaces[surface], triangle, qcColorOfSet(m_state.marks == qc_marksSets ? set : qc_setNfv)); });
}

void View::CollectLines()
{
    m_lines.Begin(m_camera.Distance() * btScalar(0.005));
    m_drawing->setModes(m_state.modes);
    m_drawing->debugDraw(&m_lines);
    if (m_state.picked == nullptr)
        return;
    const btBroadphaseProxy* proxy = m_state.picked->getBroadphaseHandle();
    if ((proxy->m_aabbMax - proxy->m_aabbMin).length() < 1000)
        m_lines.drawBox(proxy->m_aabbMin, proxy->m_aabbMax, btVector3(1, btScalar(0.75), btScalar(0.1)));
}

qcViewColors View::ColorsOf(const qcViewSurface& surface) const
{
    // Linear RGB.
    static const float palette[6][3] = {{0.60f, 0.20f, 0.08f}, {0.08f, 0.27f, 0.50f}, {0.28f, 0.40f, 0.10f},
                                        {0.62f, 0.42f, 0.08f}, {0.33f, 0.14f, 0.40f}, {0.10f, 0.42f, 0.40f}};
    qcViewColors colors;
    if (surface.unbounded)
        colors = {{0.62f, 0.63f, 0.64f}, {0.5f, 0.5f, 0.5f}};
    else if (m_state.marks != qc_marksNone)
        // Grey, below the colours of the marks.
        return {{0.52f, 0.52f, 0.50f}, {0.66f, 0.66f, 0.62f}};
    else if (!m_scene->ColorsOf(surface.object, &colors))
    {
        const float* c = palette[surface.number % 6];
        colors = {{c[0], c[1], c[2]}, {c[0], c[1], c[2]}};
    }
    return colors;
}

void View::Draw()
{
    qcViewFrame frame;
    frame.camera = &m_camera;
    for (const qcViewSurface& surface : m_geometry.Surfaces())
        frame.items.push_back({&surface, ColorsOf(surface), surface.object == m_state.picked && !surface.unbounded});
    frame.marks = &m_marks;
    frame.lines = &m_lines;
    frame.lower = m_geometry.Lower();
    frame.upper = m_geometry.Upper();
    glfwGetFramebufferSize(m_window.Get(), &frame.width, &frame.height);
    if (frame.width > 0 && frame.height > 0)
        m_renderer->Draw(frame);
}

void View::Pick(btScalar x, btScalar y)
{
    ImVec2 size = ImGui::GetIO().DisplaySize;
    btVector3 from = m_camera.Eye();
    btVector3 to = from + m_camera.Ray(2 * x / btScalar(size.x) - 1, 1 - 2 * y / btScalar(size.y),
                                       btScalar(size.x) / btScalar(size.y)) *
                              (m_camera.Distance() * 100);
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    m_scene->World().rayTest(from, to, hit);
    m_state.picked = hit.hasHit() ? hit.m_collisionObject : nullptr;
    if (m_state.picked != nullptr)
        m_state.pickedId = m_state.picked->getBroadphaseHandle()->m_uniqueId;
}

void View::HandleMouse()
{
    const ImGuiIO& io = ImGui::GetIO();
    if (io.WantCaptureMouse)
        return;
    btScalar right = btScalar(io.MouseDelta.x), up = btScalar(-io.MouseDelta.y);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left))
    {
        // The motion up to the click is no dragging.
        m_pressed = io.MousePos;
        return;
    }
    bool isStill = std::abs(io.MousePos.x - m_pressed.x) + std::abs(io.MousePos.y - m_pressed.y) < 4;
    if (ImGui::IsMouseReleased(ImGuiMouseButton_Left) && isStill)
        Pick(btScalar(io.MousePos.x), btScalar(io.MousePos.y));
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left) && !io.KeyShift)
        m_camera.Orbit(right * btScalar(0.008), -up * btScalar(0.008));
    else if (ImGui::IsMouseDown(ImGuiMouseButton_Right) || ImGui::IsMouseDown(ImGuiMouseButton_Middle) ||
             ImGui::IsMouseDown(ImGuiMouseButton_Left))
        m_camera.Pan(right / btScalar(io.DisplaySize.y), up / btScalar(io.DisplaySize.y));
    if (io.MouseWheel != 0)
        m_camera.Zoom(std::pow(btScalar(0.88), btScalar(io.MouseWheel)));
}

void View::HandleKey(int key)
{
    if (key == GLFW_KEY_SPACE)
        m_state.paused = !m_state.paused || m_state.finished;
    else if (key == GLFW_KEY_N)
        m_state.paused = m_state.stepOnce = true;
    else if (key == GLFW_KEY_R)
        m_state.restart = true;
    else if (key == GLFW_KEY_ESCAPE)
        m_state.picked = nullptr;
    else if (key == GLFW_KEY_F && m_state.picked != nullptr)
    {
        const btBroadphaseProxy* proxy = m_state.picked->getBroadphaseHandle();
        m_camera.LookAt((proxy->m_aabbMin + proxy->m_aabbMax) / 2);
    }
}

/// Mouse, keys, and what the panels have requested.
void View::Handle()
{
    HandleMouse();
    for (int key : s_keys)
        if (!ImGui::GetIO().WantCaptureKeyboard)
            HandleKey(key);
    s_keys.clear();
    if (m_state.changedSetting != 0)
        ChangeSetting();
    if (m_state.restart)
        Restart();
    m_state.restart = false;
}

bool View::WriteScreenshot(std::string* message)
{
    int width, height;
    glfwGetFramebufferSize(m_window.Get(), &width, &height);
    size_t row = 3 * size_t(width);
    std::vector<uint8_t> pixels(row * size_t(height)), flipped(pixels.size());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    for (size_t y = 0; y < size_t(height); y++)
        std::memcpy(&flipped[y * row], &pixels[(size_t(height) - 1 - y) * row], row);
    qcMessage failure;
    if (qcPng_Write(m_options.screenshot, uint32_t(width), uint32_t(height), flipped.data(), &failure))
        return true;
    *message = failure.text;
    return false;
}

void View::CountFrame()
{
    double now = qcStopwatch_NowMs(), rate = 1000 / std::max(now - m_frameStart, 0.01);
    m_state.framesASecond = m_frameStart == 0 ? 0 : 0.9 * m_state.framesASecond + 0.1 * rate;
    m_frameStart = now;
}

int View::Run()
{
    std::string message;
    bool isScreenshot = m_options.screenshot != nullptr;
    if (!m_window.Open(m_scene->Title(), !isScreenshot, &message))
        return Fail(qc_exitDevice, message);
    m_renderer = std::make_unique<qcViewRenderer>();
    if (!m_renderer->Create(&message))
        return Fail(qc_exitDevice, "--view: " + message);
    BeginWorld();
    for (uint32_t frame = 1; glfwWindowShouldClose(m_window.Get()) == 0 && qcInterrupt_Signal() == 0; frame++)
    {
        glfwPollEvents();
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        Handle();
        Step();
        ReadGeometry();
        Cull();
        CollectMarks();
        CollectLines();
        Draw();
        qcDrawPanels({m_scene, &m_settings, &m_costs, &m_culling.Sets(), &m_geometry.Surfaces()}, &m_state);
        ImGui::Render();
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        if (isScreenshot && frame >= m_options.frames)
            return WriteScreenshot(&message) ? qc_exitDone : Fail(qc_exitFailed, message);
        glfwSwapBuffers(m_window.Get());
        CountFrame();
    }
    return qcInterrupt_ExitStatus();
}
} // namespace

int qcView_Run(qcViewedScene* scene, const qcViewOptions& options, qcDevice* device)
{
    View view(scene, options, device);
    return view.Run();
}
